// SPDX-License-Identifier: Apache-2.0
// Limits a twist and keeps its curvature. The computation of the component, without messages.
#pragma once

#include <algorithm>
#include <cmath>

#include <tandem/config/params.hpp>
#include <tandem/model/se2.hpp>

namespace example {

struct SpeedLimits {
  double max_speed = 0.5;
  double max_turn_rate = 0.8;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("max_speed", max_speed, tandem::Range{0.01, 10.0}, "[m/s] forward and backward");
    field("max_turn_rate", max_turn_rate, tandem::Range{0.01, 10.0}, "[rad/s] to either side");
  }
};

/// The factor, at most 1, by which `twist` [m/s, rad/s] is scaled down to be within the limits.
[[nodiscard]] inline double factor_for(const tandem::Twist2& twist, const SpeedLimits& limits) {
  return 1.0 / std::max({1.0, std::abs(twist.v) / limits.max_speed,
                         std::abs(twist.w) / limits.max_turn_rate});
}

}  // namespace example
