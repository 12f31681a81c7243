// SPDX-License-Identifier: Apache-2.0
// The other process of the runtime's tests. `peer echo`: sends each Twist of /ping back on /pong.
// `peer trigger`: serves /trigger. `peer ask`: calls it once and prints the answer; it has two
// nodes. `peer listen`: answers each Odometry, Joy and PointCloud2 of /odom, /joy and /points on
// /pong. `peer join`: ends with 0 as soon as it has heard three messages of /odom. `peer probe`:
// for 2 s hears /cmd_vel, /odom and /joy and drives backwards on /cmd_vel and /joy; ends with 3 if
// it heard anything or anybody heard it. `peer meet N`: reports on /met once its publisher of
// /meeting is matched with N subscriptions, one in each such process. `peer pair`: has two nodes.
// `peer throw`: a callback throws. Ends with 0 on SIGTERM.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "tandem/runtime/node.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace {

using tandem::geometry_msgs::msg::Twist;
using tandem::std_srvs::srv::Trigger;
namespace rt = tandem::rt;

void echo() {
  rt::Node node{"echo"};
  // Latched: each end discovers the other in its own time, and an answer that is written before its
  // reader is known would be nobody's.
  const auto pong = node.create_publisher(rt::Topic<Twist>{"pong", rt::kLatched});
  const auto ping = node.create_subscription(rt::Topic<Twist>{"ping"},
                                             [&](const Twist& message) { pong.publish(message); });
  node.spin();
}

void listen() {
  rt::Node node{"listener"};
  const auto pong = node.create_publisher(rt::Topic<Twist>{"pong", rt::kLatched});
  const auto answer = [&](const auto&) { pong.publish({}); };
  const auto odom =
      node.create_subscription(rt::Topic<tandem::nav_msgs::msg::Odometry>{"odom"}, answer);
  const auto joy =
      node.create_subscription(rt::Topic<tandem::sensor_msgs::msg::Joy>{"joy"}, answer);
  const auto points =
      node.create_subscription(rt::Topic<tandem::sensor_msgs::msg::PointCloud2>{"points"}, answer);
  node.spin();
}

void join() {
  rt::Node node{"newcomer"};
  int heard = 0;
  const auto odom = node.create_subscription(rt::Topic<tandem::nav_msgs::msg::Odometry>{"odom"},
                                             [&](const auto&) {
                                               if (++heard == 3) node.stop();
                                             });
  node.spin();
}

int probe() {
  rt::Node node{"probe"};
  int heard = 0, beats = 0;
  bool matched = false;
  const auto count = [&](const auto&) { ++heard; };
  const auto cmd_vel = node.create_subscription(rt::Topic<Twist>{"cmd_vel"}, count);
  const auto odom =
      node.create_subscription(rt::Topic<tandem::nav_msgs::msg::Odometry>{"odom"}, count);
  const auto joy = node.create_publisher(rt::Topic<tandem::sensor_msgs::msg::Joy>{"joy"});
  const auto drive = node.create_publisher(rt::Topic<Twist>{"cmd_vel"});
  const auto beat = node.create_wall_timer(0.02, [&] {
    Twist backwards;
    backwards.linear().x(-0.77);
    drive.publish(backwards);
    tandem::sensor_msgs::msg::Joy stick;
    stick.axes({0.0F, -1.0F});
    stick.buttons({1, 0});
    joy.publish(stick);
    matched = matched || drive.matched() > 1 || joy.matched() > 0;  // its own hears it
    if (++beats == 100) node.stop();
  });
  node.spin();
  return heard > beats || matched ? 3 : 0;  // its own commands come back
}

void trigger() {
  rt::Node node{"server"};
  const auto service = node.create_service(rt::ServiceName<Trigger>{"trigger"},
                                           [](const auto&, Trigger::Response& response) {
                                             response.success(true);
                                             response.message("from another process");
                                           });
  node.spin();
}

void ask() {
  const rt::Node beside{"beside"};
  rt::Node node{"asker"};
  const auto client = node.create_client(rt::ServiceName<Trigger>{"trigger"});
  constexpr double kPatience = 30.0;  // [s]
  const auto print = [&](const Trigger::Response& response) {
    std::printf("%s\n", response.message().c_str());
    node.stop();
  };
  client.call({}, print, kPatience, [&] { node.stop(); });
  node.spin();
}

void meet(int others) {
  rt::Node node{"participant_of_the_meeting"};
  const auto met = node.create_publisher(rt::Topic<Twist>{"met", rt::kLatched});
  const auto meeting = node.create_publisher(rt::Topic<Twist>{"meeting"});
  const auto of_others = node.create_subscription(rt::Topic<Twist>{"meeting"}, [](const auto&) {});
  bool reported = false;
  const auto look = node.create_wall_timer(0.1, [&] {
    if (!reported && meeting.matched() >= others) met.publish({});
    reported = reported || meeting.matched() >= others;
  });
  node.spin();
}

void pair() {
  rt::Node first{"first"};
  const rt::Node second{"second"};
  first.spin();
}

void throw_in_callback() {
  rt::Node node{"thrower"};
  const auto timer = node.create_timer(0.01, [] { throw std::runtime_error("on purpose"); });
  node.spin();
}

}  // namespace

int main(int argc, char** argv) try {
  rt::install_signal_handlers();
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "echo") echo();
  if (mode == "join") join();
  if (mode == "probe") return probe();
  if (mode == "listen") listen();
  if (mode == "trigger") trigger();
  if (mode == "ask") ask();
  if (mode == "meet" && argc > 2) meet(std::atoi(argv[2]));
  if (mode == "pair") pair();
  if (mode == "throw") throw_in_callback();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "peer: %s\n", error.what());
  return 1;
}
