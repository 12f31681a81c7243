// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "driver/driver.hpp"
#include "robot_state_input.hpp"
#include "runtime/node.hpp"

namespace tandem {

struct DriverNodeParams {
  DriverParams driver;
  RobotStateParams input;
  bool steers_leader = true;
  int seed = 1;

  template <class Visitor>
  void visit(Visitor&& field) {
    driver.visit(field);
    input.visit(field);
    field("steers_leader", steers_leader, "watches the leader, not the robot, where there is one");
    field("seed", seed, Range{0, 2147483647}, "of the hand's and the eye's noise");
  }
};

/// odom, tf, leader_pose → joy: a simulated person with the dead-man button held. Lets go of the
/// button when the end of the route is reached, or while nobody knows where the robot is.
class DriverNode {
 public:
  explicit DriverNode(rt::Node& node);

 private:
  void tick();
  void publish(const Hand& hand, bool deadman);

  rt::Node& node_;
  rt::Parameters<DriverNodeParams> params_;
  Driver driver_;
  RobotStateInput robot_;
  std::optional<Pose2> X_ML_;
  double leader_time_ = 0.0;

  rt::Publisher<sensor_msgs::msg::Joy> joy_;
  rt::Subscription leader_;
  rt::Timer timer_;
};

}  // namespace tandem
