// SPDX-License-Identifier: Apache-2.0
// Shared by the Cyclone DDS peers: a participant that discovers Tandem's, ROS 2's names and QoS.
#pragma once

#include <stdio.h>
#include <stdlib.h>

#include "dds/dds.h"

static inline dds_entity_t need(dds_entity_t entity, const char* what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "cyclone: %s: %s\n", what, dds_strretcode(-entity));
  exit(2);
}

// Loopback only. Unicast to 127.0.0.1 in addition to multicast discovers peers that use either.
static inline dds_entity_t create_participant(dds_domainid_t domain) {
  static const char kConfig[] =
      "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>"
      "</Interfaces></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
      "<MaxAutoParticipantIndex>31</MaxAutoParticipantIndex>"
      "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";
  need(dds_create_domain(domain, kConfig), "domain");
  return need(dds_create_participant(domain, NULL, NULL), "participant");
}

// idlc uses the type name of the IDL; on the wire ROS 2 uses `dds_type`.
static inline dds_entity_t create_topic(dds_entity_t participant, const dds_topic_descriptor_t* idl,
                                        const char* name, const char* dds_type) {
  dds_topic_descriptor_t descriptor = *idl;
  descriptor.m_typename = dds_type;
  return need(dds_create_topic(participant, &descriptor, name, NULL, NULL), name);
}

// ROS 2's default profile: reliable, volatile, keep last 10, plain CDR.
static inline dds_qos_t* default_profile(void) {
  static const dds_data_representation_id_t kXcdr1[] = {DDS_DATA_REPRESENTATION_XCDR1};
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  dds_qset_data_representation(qos, 1, kXcdr1);
  return qos;
}
