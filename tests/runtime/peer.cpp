// SPDX-License-Identifier: Apache-2.0
// The other process of the runtime's tests. `peer echo`: sends each Twist of /ping back on /pong.
// `peer trigger`: serves /trigger. `peer ask`: calls it once and prints the answer.
// `peer listen`: answers each Odometry, Joy and PointCloud2 of /odom, /joy and /points on /pong.
// `peer join`: ends with 0 as soon as it has heard three messages of /odom.
// `peer throw`: a callback throws. Ends with 0 on SIGTERM.
#include <cstdio>
#include <stdexcept>
#include <string>

#include "runtime/node.hpp"
#include "runtime/shutdown.hpp"

namespace {

using geometry_msgs::msg::Twist;
using std_srvs::srv::Trigger;
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
  const auto odom = node.create_subscription(rt::Topic<nav_msgs::msg::Odometry>{"odom"}, answer);
  const auto joy = node.create_subscription(rt::Topic<sensor_msgs::msg::Joy>{"joy"}, answer);
  const auto points =
      node.create_subscription(rt::Topic<sensor_msgs::msg::PointCloud2>{"points"}, answer);
  node.spin();
}

void join() {
  rt::Node node{"newcomer"};
  int heard = 0;
  const auto odom =
      node.create_subscription(rt::Topic<nav_msgs::msg::Odometry>{"odom"}, [&](const auto&) {
        if (++heard == 3) node.stop();
      });
  node.spin();
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
  if (mode == "listen") listen();
  if (mode == "trigger") trigger();
  if (mode == "ask") ask();
  if (mode == "throw") throw_in_callback();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "peer: %s\n", error.what());
  return 1;
}
