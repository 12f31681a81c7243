// SPDX-License-Identifier: Apache-2.0
// A filter on a map, poses before a wall, and what the filter does with one command there.
#pragma once

#include <memory>
#include <utility>

#include "safety_filter/scenes.hpp"
#include "tandem/safety_filter/safety_filter.hpp"

namespace tandem::test {

inline SafetyFilter filter_on(std::shared_ptr<const StaticMap> map,
                              const SafetyFilterParams& params = {}) {
  SafetyFilter filter(params, kMir);
  filter.on_map(std::move(map));
  return filter;
}

inline RobotState at(double x, double y = 0.0, double theta = 0.0, Twist2 twist = {}) {
  return {{x, y, theta}, twist, 0.0};
}

// Pose with the bumper `gap` before the wall.
inline RobotState facing_wall(double gap, Twist2 twist = {}) {
  return at(1.5 - kBumper - gap, 0.0, 0.0, twist);
}

inline Filtered once(const Twist2& command, const RobotState& state,
                     std::shared_ptr<const StaticMap> map = wall_ahead()) {
  SafetyFilter filter = filter_on(std::move(map));
  filter.on_command(command, 0.0);
  return filter.update(state, 0.0);
}

}  // namespace tandem::test
