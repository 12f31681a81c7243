// SPDX-License-Identifier: Apache-2.0
// Runs the planner over DDS, with an integrator of its commands instead of a robot.
#pragma once

#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "system/one_component.hpp"

namespace tandem::test {

// The planner, and an integrator of its commands instead of a robot.
class PlannerOverDds : public OneComponent {
 protected:
  // Long timeouts and no solve-time limit: a busy machine must not look like a missing input or a
  // slow solver.
  explicit PlannerOverDds(const Values& values = {{"method", "goal"}}) {
    Values all{{"map_is_odom", "true"}, {"odom_timeout", "0.4"},     {"obstacle_timeout", "0.4"},
               {"user_timeout", "0.4"}, {"in_force_timeout", "0.4"}, {"time_budget", "0.0"},
               {"a_max", "1.0"}};
    for (const auto& [key, value] : values) all[key] = value;
    planner_ = std::make_unique<rt::RunningComponent>(load("local_planner", all));
    command_in_ = node_.create_subscription(topics::cmd_vel_shared, [this](const auto& msg) {
      command_ = from_msg(msg).value();
      command_out_.publish(msg);
    });
    status_in_ = node_.create_subscription(topics::planner_status, [this](const auto& msg) {
      status_ = msg;
      rungs_.insert(msg.source());
    });
    beat_ = node_.create_wall_timer(kBeat, [this] { beat(); });
  }

  void beat() {
    X_ = integrate(X_, command_, kBeat);
    const Odometry odometry{sees_nan_ ? Pose2{kNaN, 0.0, 0.0} : X_, command_};
    odom_.publish(to_msg(odometry, header({}, "odom"), "base_link"));
    if (sees_obstacles_) obstacles_.publish(to_msg(around_, header({}, "map")));
    if (user_) user_out_.publish(to_msg(*user_));
  }
  // A wall across the path, 8 m wide and 1 m thick.
  static Obstacle wall_at(double x) {
    return {.p_MO = {x, 0.0}, .a = 4.0, .b = 0.5, .angle = 0.5 * std::numbers::pi};
  }
  void send_goal(const Pose2& X_MG) { goal_.publish(to_msg(X_MG, header({}, "map"))); }
  [[nodiscard]] bool wait_until_driving() {
    send_goal({5.0, 0.0, 0.0});
    return wait_until([&] { return command_.v > 0.2; });
  }
  [[nodiscard]] bool wait_until_standing(Reason because) {
    return wait_until(
        [&] { return command_ == Twist2{} && from_msg(status_.reason_code()) == because; });
  }

  CapturedLog log_;
  std::unique_ptr<rt::RunningComponent> planner_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_ = node_.create_publisher(topics::odom);
  rt::Publisher<tandem_msgs::msg::ObstacleArray> obstacles_ =
      node_.create_publisher(topics::obstacles);
  rt::Publisher<geometry_msgs::msg::PoseStamped> goal_ =
      node_.create_publisher(topics::goal_pose, rt::kLatched);
  rt::Publisher<geometry_msgs::msg::Twist> command_out_ = node_.create_publisher(topics::cmd_vel);
  rt::Publisher<geometry_msgs::msg::Twist> user_out_ = node_.create_publisher(topics::cmd_vel_user);
  rt::Subscription command_in_, status_in_;
  rt::Timer beat_;

  Pose2 X_;
  Twist2 command_;
  tandem_msgs::msg::PlannerStatus status_;
  std::set<std::string> rungs_;  // that the status has named
  bool sees_obstacles_ = true, sees_nan_ = false;
  std::vector<Obstacle> around_;
  std::optional<Twist2> user_;
};

}  // namespace tandem::test
