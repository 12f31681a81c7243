// SPDX-License-Identifier: Apache-2.0
// Drives the robot through Cyclone DDS; shares only the IDL with Tandem.
//
//   cyclone_peer DOMAIN V W TIMEOUT
//
// Publishes V [m/s], W [rad/s] on /cmd_vel_user at 20 Hz and reads /odom and /cmd_vel. Exit status:
// 0 once it has received kSamples of each and the robot has moved by kDistance; 1 after TIMEOUT
// [s]; 2 on wrong arguments or if Cyclone DDS could not create an entity.
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "cyclone_dds.h"
#include "geometry_msgs.h"
#include "nav_msgs.h"

enum { kSamples = 20, kBatch = 16 };
static const double kDistance = 0.2;  // [m]

typedef geometry_msgs_msg_Twist Twist;
typedef nav_msgs_msg_Odometry Odometry;

typedef struct {
  dds_entity_t cmd_vel_user, odom, cmd_vel;
  int odoms, commands;
  double x0, y0;            // first position received [m]
  double moved, max_speed;  // largest distance from it [m], largest |v| commanded [m/s]
} Peer;

static Peer create_peer(dds_domainid_t domain) {
  static const char kTwist[] = "geometry_msgs::msg::dds_::Twist_";
  static const char kOdometry[] = "nav_msgs::msg::dds_::Odometry_";
  const dds_entity_t participant = create_participant(domain);
  const dds_topic_descriptor_t* twist = &geometry_msgs_msg_Twist_desc;
  const dds_topic_descriptor_t* odometry = &nav_msgs_msg_Odometry_desc;
  const dds_entity_t user = create_topic(participant, twist, "rt/cmd_vel_user", kTwist);
  const dds_entity_t command = create_topic(participant, twist, "rt/cmd_vel", kTwist);
  const dds_entity_t odom = create_topic(participant, odometry, "rt/odom", kOdometry);

  dds_qos_t* qos = default_profile();
  Peer peer = {0};
  peer.cmd_vel_user = need(dds_create_writer(participant, user, qos, NULL), "writer cmd_vel_user");
  peer.cmd_vel = need(dds_create_reader(participant, command, qos, NULL), "reader cmd_vel");
  peer.odom = need(dds_create_reader(participant, odom, qos, NULL), "reader odom");
  dds_delete_qos(qos);
  return peer;
}

static void on_odom(Peer* peer, const Odometry* msg) {
  const geometry_msgs_msg_Point p = msg->pose.pose.position;
  if (peer->odoms++ == 0) {
    peer->x0 = p.x;
    peer->y0 = p.y;
  }
  peer->moved = fmax(peer->moved, hypot(p.x - peer->x0, p.y - peer->y0));
}

static void on_command(Peer* peer, const Twist* msg) {
  ++peer->commands;
  peer->max_speed = fmax(peer->max_speed, fabs(msg->linear.x));
}

static void take_odom(Peer* peer) {
  void* samples[kBatch] = {NULL};
  dds_sample_info_t infos[kBatch];
  const int n = dds_take(peer->odom, samples, infos, kBatch, kBatch);
  for (int i = 0; i < n; ++i)
    if (infos[i].valid_data) on_odom(peer, samples[i]);
  if (n > 0) dds_return_loan(peer->odom, samples, n);
}

static void take_commands(Peer* peer) {
  void* samples[kBatch] = {NULL};
  dds_sample_info_t infos[kBatch];
  const int n = dds_take(peer->cmd_vel, samples, infos, kBatch, kBatch);
  for (int i = 0; i < n; ++i)
    if (infos[i].valid_data) on_command(peer, samples[i]);
  if (n > 0) dds_return_loan(peer->cmd_vel, samples, n);
}

static bool satisfied(const Peer* peer) {
  return peer->odoms >= kSamples && peer->commands >= kSamples && peer->moved > kDistance;
}

int main(int argc, char** argv) {
  if (argc != 5) {
    fprintf(stderr, "usage: cyclone_peer DOMAIN V W TIMEOUT\n");
    return 2;
  }
  Peer peer = create_peer((dds_domainid_t)atoi(argv[1]));
  const Twist twist = {.linear = {.x = atof(argv[2])}, .angular = {.z = atof(argv[3])}};
  const dds_time_t end = dds_time() + (dds_duration_t)(atof(argv[4]) * 1e9);

  while (!satisfied(&peer) && dds_time() < end) {
    dds_write(peer.cmd_vel_user, &twist);
    dds_sleepfor(DDS_MSECS(50));
    take_odom(&peer);
    take_commands(&peer);
  }
  printf("cyclone_peer: %d odom, %d cmd_vel, moved %.3f m, largest |v| commanded %.3f m/s\n",
         peer.odoms, peer.commands, peer.moved, peer.max_speed);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return satisfied(&peer) ? 0 : 1;
}
