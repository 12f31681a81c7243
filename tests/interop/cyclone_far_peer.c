// SPDX-License-Identifier: Apache-2.0
// A writer on Cyclone DDS whose sequence numbers are far ahead when a reader joins it.
//
//   cyclone_far_peer DOMAIN COUNT ANSWERS TIMEOUT
//
// Writes COUNT samples of /ping, then creates a reader of /pong and writes /ping at 100 Hz. Exit
// status: 0 once ANSWERS have come; 1 after TIMEOUT [s]; 2 on wrong arguments or if Cyclone DDS
// could not create an entity.
#include <stdio.h>
#include <stdlib.h>

#include "cyclone_dds.h"
#include "geometry_msgs.h"

enum { kBatch = 16 };

typedef geometry_msgs_msg_Twist Twist;

static int taken(dds_entity_t reader) {
  void* samples[kBatch] = {NULL};
  dds_sample_info_t infos[kBatch];
  const int n = dds_take(reader, samples, infos, kBatch, kBatch);
  if (n > 0) dds_return_loan(reader, samples, n);
  return n > 0 ? n : 0;
}

int main(int argc, char** argv) {
  static const char kTwist[] = "geometry_msgs::msg::dds_::Twist_";
  if (argc != 5) {
    fprintf(stderr, "usage: cyclone_far_peer DOMAIN COUNT ANSWERS TIMEOUT\n");
    return 2;
  }
  const dds_entity_t participant = create_participant((dds_domainid_t)atoi(argv[1]));
  const dds_topic_descriptor_t* twist = &geometry_msgs_msg_Twist_desc;
  const dds_entity_t ping = create_topic(participant, twist, "rt/ping", kTwist);
  const dds_entity_t pong = create_topic(participant, twist, "rt/pong", kTwist);
  dds_qos_t* qos = default_profile();
  const dds_entity_t writer = need(dds_create_writer(participant, ping, qos, NULL), "writer ping");
  const Twist message = {.linear = {.x = 0.1}};
  for (long i = atol(argv[2]); i > 0; --i) dds_write(writer, &message);

  const dds_entity_t reader = need(dds_create_reader(participant, pong, qos, NULL), "reader pong");
  dds_delete_qos(qos);
  const dds_time_t end = dds_time() + (dds_duration_t)(atof(argv[4]) * 1e9);
  const int wanted = atoi(argv[3]);
  int answers = 0;
  while (answers < wanted && dds_time() < end) {
    dds_write(writer, &message);
    dds_sleepfor(DDS_MSECS(10));
    answers += taken(reader);
  }
  printf("cyclone_far_peer: %d answers\n", answers);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return answers >= wanted ? 0 : 1;
}
