// SPDX-License-Identifier: Apache-2.0
// Converts between body twists and wheel speeds, and keeps commands within limits.
#pragma once

#include <algorithm>
#include <cmath>

#include "tandem/model/robot.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Rim speeds of the two wheels [m/s].
struct WheelSpeeds {
  double left = 0.0, right = 0.0;  ///< [m/s], forward positive
};

/// v_left = v − w L/2, v_right = v + w L/2 with L the wheel separation [m].
[[nodiscard]] inline WheelSpeeds to_wheels(const Twist2& twist, double separation) {
  return {twist.v - 0.5 * separation * twist.w, twist.v + 0.5 * separation * twist.w};
}

/// Inverse of to_wheels.
[[nodiscard]] inline Twist2 to_body(const WheelSpeeds& wheels, double separation) {
  return {0.5 * (wheels.left + wheels.right), (wheels.right - wheels.left) / separation};
}

/// `twist` scaled into the robot's speed limits, keeping the arc (the ratio w / v).
[[nodiscard]] inline Twist2 limit(const Twist2& twist, const RobotParams& robot) {
  double scale = 1.0;
  if (twist.v > robot.v_max) scale = std::min(scale, robot.v_max / twist.v);
  if (twist.v < robot.v_min) scale = std::min(scale, robot.v_min / twist.v);
  if (std::abs(twist.w) > robot.w_max) scale = std::min(scale, robot.w_max / std::abs(twist.w));
  return {scale * twist.v, scale * twist.w};
}

/// `value` moved toward `target` by at most `step` ≥ 0.
[[nodiscard]] inline double approach(double value, double target, double step) {
  return value + std::clamp(target - value, -step, step);
}

/// `value` moved toward `target` for `time` [s]: its magnitude falls by `braking` and rises by
/// `gaining` per second.
[[nodiscard]] inline double approach(double value, double target, double gaining, double braking,
                                     double time) {
  const double slower = std::clamp(target, std::min(0.0, value), std::max(0.0, value));
  const double braked = std::min(time, std::abs(value - slower) / braking);
  return approach(approach(value, slower, braking * braked), target, gaining * (time - braked));
}

}  // namespace tandem
