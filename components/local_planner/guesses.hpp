// SPDX-License-Identifier: Apache-2.0
// Initial guesses for the solver when an obstacle blocks the nominal trajectory.
#pragma once

#include <span>
#include <vector>

#include "tandem/local_planner/ocp/pairs.hpp"
#include "tandem/local_planner/reference.hpp"

namespace tandem {

/// Points left and right (in this order) of what first blocks the nominal trajectory, in the map
/// frame [m]. At each the body's largest disc is clear of all obstacles. A side without such a
/// point within 3 m is left out; empty if nothing blocks.
[[nodiscard]] std::vector<Eigen::Vector2d> points_beside(const Forecast& nominal, const Body& body,
                                                         std::span<const Obstacle> obstacles,
                                                         const PairLimits& limits);

/// Follows the motion as long as the robot can still brake, at `a_max` and `alpha_max`, before it
/// violates the margin, then brakes. If no stage allows that, brakes after the first twist.
[[nodiscard]] Forecast stopped_in_time(const Forecast& motion, const Body& body,
                                       std::span<const Obstacle> obstacles,
                                       const PairLimits& limits, const RobotParams& robot);

/// Whether `guess` can be moved into `motion`, stage by stage along straight lines, without
/// touching an obstacle, and both drive and turn alike: a solve from one then nearly always ends as
/// a solve from the other does. The way is sampled at three points.
[[nodiscard]] bool is_alike(const Forecast& guess, const Forecast& motion, const Body& body,
                            std::span<const Obstacle> obstacles, const PairLimits& limits);

/// Whether the motion makes little progress within `horizon` [s]: along the nominal trajectory for
/// method intention, toward `target`, the last stage's target position in M, for the others.
[[nodiscard]] bool is_stuck(Method method, const Forecast& nominal, const Eigen::Vector2d& target,
                            const Forecast& motion, double horizon, const RobotParams& robot);

}  // namespace tandem
