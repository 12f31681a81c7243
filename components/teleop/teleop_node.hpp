// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "robot_state_input.hpp"
#include "runtime/node.hpp"
#include "stamp_check.hpp"
#include "teleop/stick_holder.hpp"
#include "teleop/teleop.hpp"

namespace tandem {

struct TeleopNodeParams {
  TeleopParams teleop;
  RobotStateParams input;
  StampParams stamp;

  template <class Visitor>
  void visit(Visitor&& field) {
    teleop.visit(field);
    input.visit(field);
    stamp.visit(field);
  }
};

/// joy, odom, tf → cmd_vel_user, leader_pose, leader/markers, end_sim.
///
/// Publishes on every joy while the dead-man is held, and one zero at its release; nothing while
/// the joystick is silent.
class TeleopNode {
 public:
  explicit TeleopNode(rt::Node& node);

 private:
  void on_joy(const sensor_msgs::msg::Joy& msg);
  void publish(const Intent& intent);

  rt::Node& node_;
  rt::Parameters<TeleopNodeParams> params_;
  Teleop teleop_;
  RobotStateInput robot_;
  StickHolder holder_;
  StampCheck joy_stamp_;
  bool end_pressed_ = false;

  rt::Publisher<geometry_msgs::msg::Twist> cmd_vel_user_;
  rt::Publisher<geometry_msgs::msg::PoseStamped> leader_pose_;
  rt::Publisher<visualization_msgs::msg::MarkerArray> markers_;
  rt::Publisher<std_msgs::msg::Bool> end_sim_;
  rt::Subscription joy_;
};

}  // namespace tandem
