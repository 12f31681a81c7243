// SPDX-License-Identifier: Apache-2.0
// In: a cycle and what was planned in it. Out: whether the person comes nearer by themselves.
#pragma once

#include <optional>

#include "local_planner/cycle.hpp"

namespace tandem {

/// The programme keeps discs and a margin between the robot and everything else, which is right for
/// a robot that travels and wrong for one that docks at a desk, enters a lift or fits through a gap
/// with 7 cm on either side: there the plan stops although the outline is still far from touching.
/// A person who goes on pushing wants to be nearer. Their own command then takes the place of the
/// plan, slowed so far that they can stop in time, and the safety filter, which knows the outline
/// and every cell, decides how near is near enough.
///
/// Never without a safety filter that enforces, far from obstacles, or for a goal.
class CloseApproach {
 public:
  /// The person's twist, slowed, where the plan brings the robot less far than that twist would;
  /// nullopt where the plan is followed. Called once per cycle.
  [[nodiscard]] std::optional<Twist2> instead_of(const Plan& plan, const Cycle& cycle);

 private:
  double blocked_since_ = -1.0;  // [s]; below 0: not blocked
  bool approaches_ = false;
};

}  // namespace tandem
