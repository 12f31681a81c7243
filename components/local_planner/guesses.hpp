// SPDX-License-Identifier: Apache-2.0
// In: a wish that something blocks. Out: motions that pass it left and right, to start solves from.
#pragma once

#include <span>
#include <vector>

#include "tandem/local_planner/ocp/pairs.hpp"
#include "tandem/local_planner/reference.hpp"

namespace tandem {

/// Points beside whatever the wish runs into first: left, then right; each is clear of all
/// obstacles for the body's largest disc. Fewer where no such point lies within 3 m, none if the
/// wish is free.
[[nodiscard]] std::vector<Eigen::Vector2d> points_beside(const Forecast& wish, const Body& body,
                                                         std::span<const Obstacle> obstacles,
                                                         const PairLimits& limits);

/// The motion as far as it can be followed and still be braked, at `a_max` and `alpha_max`, before
/// the first miss of the margin; from rest, or too late to brake: braking at once.
[[nodiscard]] Forecast stopped_in_time(const Forecast& motion, const Body& body,
                                       std::span<const Obstacle> obstacles,
                                       const PairLimits& limits, const RobotParams& robot);

/// Whether the motion makes little of the way that the wish asks for within `horizon` seconds.
[[nodiscard]] bool is_stuck(const PlanRequest& request, const Forecast& wish,
                            const Forecast& motion, double horizon, const RobotParams& robot);

}  // namespace tandem
