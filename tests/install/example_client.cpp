// SPDX-License-Identifier: Apache-2.0
// Talks to the installed example component:
//   example_client drive               pushes a stick until the robot of limited_drive.yaml has
//   moved example_client load PACKAGE PLUGIN  asks `tandem container` to load a plugin, prints the
//   node's name
// Exit status 1 and a line on stderr if that fails.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

using composition_interfaces::srv::LoadNode;

constexpr double kTimeout = 60.0;  // [s] for a busy machine
constexpr double kMaxSpeed = 0.3;  // [m/s] in limited_drive.yaml
constexpr double kTravel = 0.2;    // [m]

// Until the robot has moved, full stick forward, at first at rest so that teleop accepts it.
void drive() {
  rt::Node node{"example_client"};
  double travel = 0.0, fastest = 0.0;
  const auto odom = node.create_subscription(
      rt::Topic<nav_msgs::msg::Odometry>{"odom"}, [&](const auto& message) {
        travel =
            std::hypot(message.pose().pose().position().x(), message.pose().pose().position().y());
      });
  const auto cmd_vel = node.create_subscription(
      rt::Topic<geometry_msgs::msg::Twist>{"cmd_vel"},
      [&](const auto& message) { fastest = std::max(fastest, std::abs(message.linear().x())); });
  const auto user = node.create_subscription(rt::Topic<geometry_msgs::msg::Twist>{"cmd_vel_user"},
                                             [](const auto&) {});
  const auto joy = node.create_publisher(rt::Topic<sensor_msgs::msg::Joy>{"joy"});
  const auto beat = node.create_wall_timer(0.02, [&] {
    sensor_msgs::msg::Joy message;
    message.axes({0.0f, user.sequence() > 0 ? 1.0f : 0.0f});
    message.buttons({1});
    joy.publish(message);
  });
  if (!test::spin_until([&] { return travel > kTravel; }, kTimeout, node))
    throw std::runtime_error("the robot moved " + std::to_string(travel) + " m only");
  if (fastest <= 0.0 || fastest > kMaxSpeed + 1e-9)
    throw std::runtime_error("the fastest command was " + std::to_string(fastest) + " m/s");
}

void load(const std::string& package, const std::string& plugin) {
  rt::Node node{"example_client"};
  const auto client =
      node.create_client(rt::ServiceName<LoadNode>{"/tandem_container/_container/load_node"});
  LoadNode::Request request;
  request.package_name(package);
  request.plugin_name(plugin);
  LoadNode::Response response;
  bool answered = false;
  client.call(
      request, [&](const auto& answer) { response = answer, answered = true; }, kTimeout);
  if (!test::spin_until([&] { return answered; }, kTimeout, node))
    throw std::runtime_error("the container does not answer");
  if (!response.success()) throw std::runtime_error(response.error_message());
  std::puts(response.full_node_name().c_str());
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) try {
  const std::string command = argc > 1 ? argv[1] : "";
  if (command == "drive" && argc == 2)
    tandem::drive();
  else if (command == "load" && argc == 4)
    tandem::load(argv[2], argv[3]);
  else
    throw std::invalid_argument("usage: example_client drive | load PACKAGE PLUGIN");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "example_client: %s\n", error.what());
  return 1;
}
