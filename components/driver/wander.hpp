// SPDX-License-Identifier: Apache-2.0
// The slow errors of a person's hand and eye.
#pragma once

#include <cmath>

namespace tandem {

/// One step of `dt` [s] of an Ornstein–Uhlenbeck process with the given stationary deviation and
/// correlation time [s], discretised exactly. `normal`: a fresh standard normal number.
[[nodiscard]] inline double wander(double value, double deviation, double time, double dt,
                                   double normal) {
  const double keep = std::exp(-dt / time);
  return keep * value + deviation * std::sqrt(1.0 - keep * keep) * normal;
}

}  // namespace tandem
