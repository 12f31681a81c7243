// SPDX-License-Identifier: Apache-2.0
// Parameters of the planner's actions, and when a goal is reached.
#pragma once

#include <cmath>

#include "tandem/config/params.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

struct NavigationParams {
  bool serve_actions = false;
  bool goal_needs_client = false;
  double goal_distance = 0.15;
  double goal_angle = 0.15;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("serve_actions", serve_actions,
          "true: serves Nav2's actions navigate_to_pose and follow_path; false where a Nav2 does");
    field("goal_needs_client", goal_needs_client,
          "true: a goal of an action ends when its client has left");
    field("goal_distance", goal_distance, Range{0.01, 5.0},
          "[m] within which a goal of an action is reached");
    field("goal_angle", goal_angle, Range{0.01, 3.2},
          "[rad] heading error within which a goal of an action is reached");
  }
};

/// Whether a robot at X_MB with that twist stands at the goal X_MG.
[[nodiscard]] inline bool is_reached(const Pose2& X_MB, const Twist2& twist, const Pose2& X_MG,
                                     const NavigationParams& params) {
  constexpr double kAtRest = 0.05;  // [m/s], [rad/s]
  return (X_MG.position() - X_MB.position()).norm() <= params.goal_distance &&
         std::abs(wrap_angle(X_MG.theta - X_MB.theta)) <= params.goal_angle &&
         std::abs(twist.v) <= kAtRest && std::abs(twist.w) <= kAtRest;
}

}  // namespace tandem
