// SPDX-License-Identifier: Apache-2.0
// Detects a deadlock between planner and safety filter.
#pragma once

#include "tandem/model/se2.hpp"

namespace tandem {

/// Planner and safety filter can deadlock in a narrow gap: the planner sees fitted shapes, the
/// filter map cells, and the filter can refuse the same plan forever. After 0.6 s of refused plans
/// at standstill the person's own command is passed to the filter for 1.5 s. This needs a filter
/// that reports that it enforces and refuses because of nearby obstacles: an emergency stop is not
/// a deadlock.
class Deadlock {
 public:
  /// Whether the person's command should be passed through at time t [s]. Call once per cycle.
  /// `refused`: the filter passes nothing of what it is asked for; `measured`: twist from odometry.
  [[nodiscard]] bool holds(bool refused, const Twist2& measured, double t);

 private:
  double refused_since_ = -1.0;  // [s]; below 0: not refused
  double until_ = -1e9;          // [s]
};

}  // namespace tandem
