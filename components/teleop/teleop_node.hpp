// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>

#include "tandem/io/diagnostics.hpp"
#include "tandem/io/robot_state_input.hpp"
#include "tandem/io/stamp_check.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/teleop/joy_rhythm.hpp"
#include "tandem/teleop/rest_check.hpp"
#include "tandem/teleop/stick_holder.hpp"
#include "tandem/teleop/teleop.hpp"

namespace tandem {

struct TeleopNodeParams {
  TeleopParams teleop;
  RobotParams robot;
  RobotStateParams input;
  StampParams stamp;

  template <class Visitor>
  void visit(Visitor&& field) {
    teleop.visit(field);
    robot.visit(field);
    input.visit(field);
    stamp.visit(field);
  }
};

/// joy, cmd_vel_user of others, odom, tf, planner/status → cmd_vel_user, leader_pose,
/// leader/markers, teleop/status, /diagnostics, end_sim.
///
/// Publishes on every joy while the dead-man is held, and a single zero at its release. Publishes
/// nothing while the joystick is silent, has not been seen at rest (see RestCheck) or exceeds
/// `axis_range`; teleop/status gives the reason. While no stick is held, the leader follows another
/// node's cmd_vel_user; with several such nodes, the first one until it is silent.
class TeleopNode {
 public:
  using Params = TeleopNodeParams;

  static constexpr std::size_t kMaxTroubles = 100;  // senders whose trouble is stored
  static constexpr double kPlannerTimeout = 0.5;    // [s] silence after which it does not yield
  static constexpr double kOnce = 1e9;  // [s] reminder period of messages that are logged only once

  explicit TeleopNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void on_joy(const sensor_msgs::msg::Joy& msg);
  [[nodiscard]] bool may_drive(const sensor_msgs::msg::Joy& msg, const std::string& sender,
                               const Stick& stick);
  void report(const std::string& sender, const std::string& trouble);
  void on_twist(const Twist2& twist);
  void keep_leader_near();
  [[nodiscard]] std::optional<Pose2> robot_pose();
  [[nodiscard]] Twist2 robot_twist();
  void publish_leader(const Pose2& X_ML);

  rt::Node& node_;
  rt::Parameters<TeleopNodeParams> params_;
  Teleop teleop_;
  RobotStateInput robot_;
  StickHolder holder_, writer_;  // for joy; for other publishers of cmd_vel_user
  RestCheck rest_;
  JoyRhythm rhythm_;
  StampCheck joy_stamp_;
  Stamped<bool> yielded_;  // whether the planner passes the person's command through
  bool end_pressed_ = false;
  std::map<std::string, std::string> troubles_;  // by sender of joy

  rt::Publisher<geometry_msgs::msg::Twist> cmd_vel_user_;
  rt::Publisher<geometry_msgs::msg::PoseStamped> leader_pose_;
  rt::Publisher<visualization_msgs::msg::MarkerArray> markers_;
  rt::Publisher<std_msgs::msg::Bool> end_sim_;
  rt::Publisher<std_msgs::msg::String> status_;
  Diagnostics diagnostics_;
  rt::Subscription joy_, planner_;
  TwistInput on_twist_;
  std::shared_ptr<void> time_jump_;
};

}  // namespace tandem
