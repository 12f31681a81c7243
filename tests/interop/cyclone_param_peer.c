// SPDX-License-Identifier: Apache-2.0
// Sets a parameter of a node through Cyclone DDS; shares only the IDL with Tandem.
//
//   cyclone_param_peer DOMAIN NODE PARAMETER VALUE TIMEOUT
//
// Sets the floating-point PARAMETER of NODE ("/ns/name") to VALUE and reads it back. Exit status: 0
// if it was set to VALUE; 1 after TIMEOUT [s]; 2 on wrong arguments or if an entity could not be
// created; 3 if the set was refused.
//
// The identity of a response is in inline QoS, which Cyclone DDS does not expose, so no other
// client may use these services at the same time.
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cyclone_dds.h"
#include "rcl_interfaces.h"

typedef struct {
  dds_entity_t writer, reader;
} Client;

typedef struct {
  const char* name;  // "GetParameters"
  const dds_topic_descriptor_t *request, *response;
} ServiceType;

static Client create_client(dds_entity_t participant, const char* service, ServiceType type) {
  char topic[256], dds_type[256];
  dds_qos_t* qos = default_profile();
  snprintf(topic, sizeof topic, "rq%sRequest", service);
  snprintf(dds_type, sizeof dds_type, "rcl_interfaces::srv::dds_::%s_Request_", type.name);
  const dds_entity_t request = create_topic(participant, type.request, topic, dds_type);
  snprintf(topic, sizeof topic, "rr%sReply", service);
  snprintf(dds_type, sizeof dds_type, "rcl_interfaces::srv::dds_::%s_Response_", type.name);
  const dds_entity_t response = create_topic(participant, type.response, topic, dds_type);
  const Client client = {need(dds_create_writer(participant, request, qos, NULL), "writer"),
                         need(dds_create_reader(participant, response, qos, NULL), "reader")};
  dds_delete_qos(qos);
  return client;
}

static bool is_matched(const Client* client) {
  dds_publication_matched_status_t request;
  dds_subscription_matched_status_t response;
  return dds_get_publication_matched_status(client->writer, &request) == 0 &&
         dds_get_subscription_matched_status(client->reader, &response) == 0 &&
         request.current_count > 0 && response.current_count > 0;
}

// Sends the request every half second until take() accepts a response; false if none was accepted
// by `end`.
static bool call(const Client* client, const void* request, dds_time_t end,
                 bool (*take)(const void* response, double* out), double* out) {
  dds_time_t next = 0;
  for (; dds_time() < end; dds_sleepfor(DDS_MSECS(5))) {
    if (is_matched(client) && dds_time() >= next) {
      dds_write(client->writer, request);
      next = dds_time() + DDS_MSECS(500);
    }
    void* samples[1] = {NULL};
    dds_sample_info_t info;
    const int n = dds_take(client->reader, samples, &info, 1, 1);
    if (n <= 0) continue;
    const bool good = info.valid_data && take(samples[0], out);
    dds_return_loan(client->reader, samples, n);
    if (good) return true;
  }
  return false;
}

static bool take_value(const void* response, double* out) {
  const rcl_interfaces_srv_GetParameters_Response* got = response;
  if (got->values._length != 1) return false;
  *out = got->values._buffer[0].double_value;
  return got->values._buffer[0].type == 3;  // PARAMETER_DOUBLE
}

static bool take_result(const void* response, double* out) {
  const rcl_interfaces_srv_SetParameters_Response* got = response;
  if (got->results._length != 1) return false;
  if (!got->results._buffer[0].successful)
    fprintf(stderr, "cyclone_param_peer: refused: %s\n", got->results._buffer[0].reason);
  *out = got->results._buffer[0].successful;
  return true;
}

int main(int argc, char** argv) {
  if (argc != 6) {
    fprintf(stderr, "usage: cyclone_param_peer DOMAIN NODE PARAMETER VALUE TIMEOUT\n");
    return 2;
  }
  const dds_entity_t participant = create_participant((dds_domainid_t)atoi(argv[1]));
  char service[200];
  snprintf(service, sizeof service, "%s/set_parameters", argv[2]);
  const Client set =
      create_client(participant, service,
                    (ServiceType){"SetParameters", &rcl_interfaces_srv_SetParameters_Request_desc,
                                  &rcl_interfaces_srv_SetParameters_Response_desc});
  snprintf(service, sizeof service, "%s/get_parameters", argv[2]);
  const Client get =
      create_client(participant, service,
                    (ServiceType){"GetParameters", &rcl_interfaces_srv_GetParameters_Request_desc,
                                  &rcl_interfaces_srv_GetParameters_Response_desc});

  char empty[] = "";
  rcl_interfaces_msg_Parameter parameter;
  memset(&parameter, 0, sizeof parameter);
  parameter.name = argv[3];
  parameter.value.type = 3;
  parameter.value.double_value = atof(argv[4]);
  parameter.value.string_value = empty;
  const rcl_interfaces_srv_SetParameters_Request wish = {
      .parameters = {._maximum = 1, ._length = 1, ._buffer = &parameter}};
  const rcl_interfaces_srv_GetParameters_Request question = {
      .names = {._maximum = 1, ._length = 1, ._buffer = &argv[3]}};

  const dds_time_t end = dds_time() + (dds_duration_t)(atof(argv[5]) * 1e9);
  double done = 0.0, value = 0.0;
  const bool answered =
      call(&set, &wish, end, take_result, &done) && call(&get, &question, end, take_value, &value);
  printf("cyclone_param_peer: %s, set %s, value %g\n", answered ? "answered" : "no answer",
         done != 0.0 ? "taken" : "refused", value);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  if (!answered) return 1;
  return done != 0.0 && value == parameter.value.double_value ? 0 : 3;
}
