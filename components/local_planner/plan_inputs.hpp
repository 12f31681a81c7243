// SPDX-License-Identifier: Apache-2.0
// Keeps the planner's inputs, decides whether they suffice, and combines them into a request.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/local_planner/given_path.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/model/localization.hpp"
#include "tandem/model/reasons.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

struct PlanInputParams {
  double user_timeout = 0.12;
  double obstacle_timeout = 0.1;
  double in_force_timeout = 0.2;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("user_timeout", user_timeout, Range{0.02, 5.0},
          "[s] the robot stops when leader_pose or cmd_vel_user has been silent for this long");
    field("obstacle_timeout", obstacle_timeout, Range{0.02, 5.0},
          "[s] the robot stops when obstacles has been silent for this long");
    field("in_force_timeout", in_force_timeout, Range{0.02, 5.0},
          "[s] age of cmd_vel, the command in force, beyond which it counts as zero");
  }
};

/// The last value of each input, in the map frame M. Times are seconds on one monotonic clock.
class PlanInputs {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  explicit PlanInputs(const PlanInputParams& params, std::vector<GuidanceLine> guidance = {});

  void on_obstacles(std::vector<Obstacle> obstacles, double t) {
    obstacles_ = {std::move(obstacles), t};
  }
  /// The person's command.
  void on_user(const Twist2& twist, double t) { user_ = {twist, t}; }
  /// The command in force, which the base obeys.
  void on_command(const Twist2& twist, double t) { command_ = {twist, t}; }
  void on_leader(const Pose2& X_ML, double t) { leader_ = {X_ML, t}; }
  /// The goal never becomes too old.
  void on_goal(const Pose2& X_MG) { X_MG_ = X_MG; }
  /// A path for method path, to be followed instead of the leader until drop_goals(). Must not be
  /// empty.
  void on_path(std::span<const Pose2> path);
  /// Discards goal and path: the robot stands until there is a new one.
  void drop_goals();
  /// The robot is at p_MB: it has passed the path up to there.
  void advance(const Eigen::Vector2d& p_MB) { path_.advance(p_MB); }
  /// Length of the path that the robot has not passed [m].
  [[nodiscard]] double path_left() const { return path_.length(); }
  /// `enforces`, `refuses`: what the safety filter reports, see PlanRequest::guarded and refused.
  void on_filter(bool enforces, bool refuses, double t) { filter_ = {{enforces, refuses}, t}; }
  /// Call after the clock jumped back: discards all inputs but goal and path.
  void on_time_jump();

  /// Why there can be no request for that method now; nullopt if there can be one.
  [[nodiscard]] std::optional<Reason> missing(Method method, double now) const;
  /// The request at time `now`. Its spans are valid until the next call of a function that is not
  /// const.
  [[nodiscard]] PlanRequest request(Method method, const RobotState& robot, double now) const;

 private:
  void ask_for_path(PlanRequest& request) const;

  struct FilterState {
    bool enforces = false, refuses = false;
  };

  PlanInputParams params_;
  std::vector<GuidanceLine> guidance_;
  Stamped<std::vector<Obstacle>> obstacles_;
  Stamped<Twist2> user_, command_;
  Stamped<Pose2> leader_;
  Stamped<FilterState> filter_;
  std::optional<Pose2> X_MG_, X_ME_;  // goal; end of the path
  GivenPath path_;
};

}  // namespace tandem
