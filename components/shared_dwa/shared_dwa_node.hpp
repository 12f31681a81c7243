// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "tandem/io/diagnostics.hpp"
#include "tandem/io/map_input.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/shared_dwa/shared_dwa.hpp"

namespace tandem {

struct SharedDwaNodeParams {
  RobotParams robot;
  SharedDwaParams dwa;
  MapInputParams map;
  RobotStateParams input;
  StampParams stamp;
  double user_timeout = 0.12;

  template <class Visitor>
  void visit(Visitor&& field) {
    robot.visit(field);
    dwa.visit(field);
    map.visit(field);
    input.visit(field);
    stamp.visit(field);
    field("user_timeout", user_timeout, Range{0.02, 5.0},
          "[s] the robot stops when cmd_vel_user has been silent for this long");
  }
};

/// cmd_vel_user, octomap_binary, octomap_local, odom, tf → cmd_vel_shared, planner/status,
/// /diagnostics.
///
/// Replaces local_planner. Chooses once per control period; while a required input is silent it
/// publishes zero and the reason.
class SharedDwaNode {
 public:
  using Params = SharedDwaNodeParams;
  explicit SharedDwaNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void choose();
  void publish(const DwaChoice& choice, double time);
  void stop_in_trouble(const std::string& reason, const char* waits_for);
  void stop(const std::string& reason);

  rt::Node& node_;
  rt::Parameters<SharedDwaNodeParams> params_;
  SharedDwa dwa_;
  RobotStateInput robot_;
  MapInput map_;
  Stamped<Twist2> user_;
  rt::StateLog reasons_{node_.log(), 1.0};  ///< for standing
  tandem_msgs::msg::PlannerStatus status_;

  rt::Publisher<geometry_msgs::msg::Twist> cmd_vel_shared_;
  rt::Publisher<tandem_msgs::msg::PlannerStatus> status_out_;
  Diagnostics diagnostics_;
  TwistInput on_user_;
  rt::Timer timer_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
