// SPDX-License-Identifier: Apache-2.0
// In: a cycle and what was planned in it. Out: the person's own twist where plans come to nothing.
#pragma once

#include <optional>

#include "tandem/local_planner/cycle.hpp"

namespace tandem {

/// Whether the person has pushed for 5 s without moving anything. They then want past what is in
/// the way, not nearer to it, until the robot has come 0.5 m away or the stick has been at rest.
class InVain {
 public:
  /// Called once per cycle.
  [[nodiscard]] bool holds(bool approaches, const PlanRequest& request);

 private:
  double standing_since_ = 0.0;  // [s]
  std::optional<Eigen::Vector2d> gave_up_at_;
};

/// Lets the person come near something on purpose. The programme keeps discs and a margin between
/// the robot and every obstacle. That suits a robot that travels, but a person who docks at a desk,
/// enters a lift or passes a gap with 7 cm to spare on either side wants to be nearer: there the
/// plans come to nothing while the outline is still far from touching. If the person goes on
/// pushing about straight, their own twist replaces the plan, slowed to 0.5 m/s and 0.8 rad/s at
/// most, until plans get on again, the stick is pulled back, or the person has pushed in vain. The
/// safety filter, which knows the outline and every cell, decides how near is near enough.
///
/// Never without a safety filter that enforces, away from obstacles, or for a goal.
class CloseApproach {
 public:
  /// The person's twist, slowed, if plans have come to nothing for 0.3 s; nullopt if the plan is to
  /// be followed. To be called once per cycle.
  [[nodiscard]] std::optional<Twist2> instead_of(const Plan& plan, const Cycle& cycle);

  /// Whether the person's twist was the last answer.
  [[nodiscard]] bool is_near() const { return approaches_; }

 private:
  double blocked_since_ = -1.0;  // [s]; below 0: not blocked
  bool approaches_ = false;
  Twist2 last_ = {};
  InVain in_vain_;
};

}  // namespace tandem
