// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "tandem/driver/driver.hpp"
#include "tandem/io/map_input.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct DriverNodeParams {
  DriverParams driver;
  RobotStateParams input;
  MapInputParams map;
  bool steers_leader = true;
  int seed = 1;

  template <class Visitor>
  void visit(Visitor&& field) {
    driver.visit(field);
    input.visit(field);
    map.visit(field);
    field("steers_leader", steers_leader,
          "true: watches the leader instead of the robot, if there is one");
    field("seed", seed, Range{0, 2147483647}, "seed of the noise of hand and eye");
  }
};

/// odom, tf, leader_pose, teleop/status, octomap_binary → joy: a simulated person. They hold the
/// dead-man button, and release it when done and while the robot's pose is unknown. Only an
/// adversary uses the map.
class DriverNode {
 public:
  using Params = DriverNodeParams;
  explicit DriverNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void tick();
  [[nodiscard]] Hand taken(const Hand& hand);
  void publish(const Hand& meant);

  rt::Node& node_;
  rt::Parameters<DriverNodeParams> params_;
  Driver driver_;
  RobotStateInput robot_;
  std::optional<MapInput> map_;
  Stamped<Pose2> X_ML_;
  bool holds_ = false;   // whether the last sample held the dead-man
  bool let_go_ = false;  // teleop reported that the stick has no effect

  rt::Publisher<sensor_msgs::msg::Joy> joy_;
  rt::Subscription leader_, on_trouble_;
  rt::Timer timer_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
