// SPDX-License-Identifier: Apache-2.0
// Converts between the position of a stick and the deflection that counts beyond its dead zone.
#pragma once

#include <algorithm>
#include <cmath>

namespace tandem {

/// Deflection in [−1, 1] of a stick at `position` [1]: zero within the dead zone, then linear to
/// ±1. `dead_zone`: fraction of the travel that counts as rest, below 1.
[[nodiscard]] inline double beyond_dead_zone(double position, double dead_zone) {
  const double travel = std::min(std::abs(position), 1.0);
  if (travel <= dead_zone) return 0.0;
  return std::copysign((travel - dead_zone) / (1.0 - dead_zone), position);
}

/// Inverse of beyond_dead_zone(): where to push the stick for a deflection in [−1, 1].
[[nodiscard]] inline double through_dead_zone(double deflection, double dead_zone) {
  if (deflection == 0.0) return 0.0;
  return std::copysign(dead_zone + (1.0 - dead_zone) * std::abs(deflection), deflection);
}

}  // namespace tandem
