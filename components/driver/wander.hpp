// SPDX-License-Identifier: Apache-2.0
// A random process for the slow errors of a person's hand and eye.
#pragma once

#include <cmath>

namespace tandem {

/// One step of an Ornstein–Uhlenbeck process with the given stationary deviation and correlation
/// time [s], discretised exactly at `rate` [Hz]. `normal`: a new standard normal sample.
[[nodiscard]] inline double wander(double value, double deviation, double time, double rate,
                                   double normal) {
  const double keep = std::exp(-1.0 / (rate * time));
  return keep * value + deviation * std::sqrt(1.0 - keep * keep) * normal;
}

}  // namespace tandem
