// SPDX-License-Identifier: Apache-2.0
// In: whether the safety filter refuses what is planned. Out: whether the plans come to nothing.
#pragma once

#include "tandem/model/se2.hpp"

namespace tandem {

/// Between two obstacles that stand nearer than the margin, planner and safety filter can disagree
/// for ever: the planner sees shapes, the filter cells, and what the planner asks for again and
/// again the filter never lets pass. Then the person, who looks at it, is worth more than the plan:
/// their own command goes to the filter for a while. Without a filter that says that it enforces,
/// and refuses for what is near, nobody ever has their way: an emergency stop is no stalemate.
class Deadlock {
 public:
  /// Whether the person should have their way at time t [s]. `refused`: the filter lets nothing of
  /// what it is asked for pass; `measured`: what the robot does.
  [[nodiscard]] bool holds(bool refused, const Twist2& measured, double t);

 private:
  double refused_since_ = -1.0;  // [s]; below 0: not refused
  double until_ = -1e9;          // [s]
};

}  // namespace tandem
