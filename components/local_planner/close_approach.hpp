// SPDX-License-Identifier: Apache-2.0
// Decides when the person's own twist replaces a plan that makes no progress near an obstacle.
#pragma once

#include <optional>

#include "tandem/local_planner/cycle.hpp"

namespace tandem {

/// Detects that the person has pushed for 5 s while the robot stands. They then want to get past
/// the obstacle, not closer to it. Holds until the robot is 0.5 m away or the stick is at rest.
class InVain {
 public:
  /// Called once per cycle.
  [[nodiscard]] bool holds(bool approaches, const PlanRequest& request);

 private:
  double standing_since_ = 0.0;  // [s]
  std::optional<Eigen::Vector2d> gave_up_at_;
};

/// Lets the person approach an obstacle on purpose. The optimal control problem keeps a margin
/// between the robot's discs and every obstacle. A person who docks at a desk, enters a lift or
/// passes a gap with 7 cm to spare on either side wants to be closer: there the plans make no
/// progress although the outline is still clear. If the person keeps pushing roughly straight,
/// their twist, limited to 0.5 m/s and 0.8 rad/s, replaces the plan until plans make progress
/// again, the stick is reversed, or InVain holds. The safety filter, which checks the outline
/// against every cell, limits how close the robot gets.
///
/// Inactive without an enforcing safety filter, away from obstacles, for a goal, for a round body,
/// and with the stick at rest.
class CloseApproach {
 public:
  /// The person's twist, slowed, if plans have been blocked for 0.3 s; nullopt to follow the plan.
  /// Call once per cycle.
  [[nodiscard]] std::optional<Twist2> instead_of(const Plan& plan, const Cycle& cycle);

  /// Whether the last call returned the person's twist.
  [[nodiscard]] bool is_near() const { return approaches_; }

 private:
  double blocked_since_ = -1.0;  // [s]; below 0: not blocked
  bool approaches_ = false;
  Twist2 last_ = {};
  InVain in_vain_;
};

}  // namespace tandem
