// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/driver_node.hpp"

#include <utility>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

constexpr double kLeaderAge = 0.5;  // [s]

}  // namespace

rt::Interface DriverNode::interface() {
  return RobotStateInput::interface() + rt::only_if("driver: adversary", MapInput::interface()) +
         rt::Interface{
             .subscribes = {{topics::leader_pose, topics::kUserInput}, topics::teleop_status},
             .publishes = {topics::joy}};
}

DriverNode::DriverNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      driver_{params_->driver, static_cast<unsigned>(params_->seed)},
      robot_{node, params_->input},
      joy_{node.create_publisher(topics::joy)} {
  if (DriverName{params_->driver.driver}.driver == "adversary")
    map_.emplace(node, params_->map, robot_.frames());
  leader_ =
      node.create_subscription(topics::leader_pose, topics::kUserInput, [this](const auto& msg) {
        const auto X_MF = robot_.frames().in_map(msg.header(), topics::leader_pose.name);
        const auto X_FL = from_msg(msg.pose());
        if (!X_MF || !X_FL) return;
        X_ML_ = {compose(*X_MF, *X_FL), node_.now()};
      });
  on_trouble_ = node.create_subscription(
      topics::teleop_status, [this](const auto& msg) { let_go_ = !msg.data().empty(); });
  timer_ = node.create_timer(1.0 / params_->driver.navigator.rate, [this] { tick(); });
  time_jump_ = node.on_time_jump([this] { X_ML_.reset(); });
}

void DriverNode::tick() {
  const auto robot = robot_.state();
  if (!robot) return publish({0.0, 0.0, false});
  if (map_) driver_.on_map(map_->map(robot));
  const bool leads = params_->steers_leader && X_ML_.fresh(node_.now(), kLeaderAge);
  publish(driver_.steer(robot->X_MB, leads ? X_ML_.value : robot->X_MB, node_.now()));
}

// Imitates a person: presses the dead-man with the stick at rest, and releases it if that has no
// effect, for example after a lost connection.
Hand DriverNode::taken(const Hand& hand) {
  const bool lets_go = !hand.holds || std::exchange(let_go_, false);
  const bool takes = !std::exchange(holds_, !lets_go);
  return lets_go || takes ? Hand{0.0, 0.0, !lets_go} : hand;
}

void DriverNode::publish(const Hand& meant) {
  const Hand hand = taken(meant);
  sensor_msgs::msg::Joy msg;
  msg.header(header(node_.stamp(), "joy"));
  msg.axes({static_cast<float>(hand.angular), static_cast<float>(hand.linear)});
  msg.buttons({hand.holds ? 1 : 0, 0});
  joy_.publish(msg);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::DriverNode, "driver")
