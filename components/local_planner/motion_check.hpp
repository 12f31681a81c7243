// SPDX-License-Identifier: Apache-2.0
// The exact check: whether the robot's true outline stays clear of the obstacles along a motion.
#pragma once

#include <span>
#include <vector>

#include "tandem/model/footprint.hpp"
#include "tandem/model/motor_lag.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// The robot as the planner sees it: discs in the optimal control problem, outline in the check.
struct Body {
  Footprint footprint;
  std::vector<Disc> discs;  ///< cover the outline, or none
  bool round = false;       ///< the first disc replaces the outline, as in Devalla's scripts
};

/// Radius of the body's largest disc [m], the half width its widest part needs. Discs of one part
/// are equal.
[[nodiscard]] double largest_radius(const Body& body);

/// Twists commanded for dt [s] each from X_MB on, starting `start` [s] after the obstacles' time.
struct Motion {
  Pose2 X_MB;
  double start = 0.0;
  double dt = 0.25;
  std::vector<Twist2> twist = {};
  MotorLag lag = {};
  Twist2 moves = {};  ///< the twist at X_MB; not read without a lag
};

/// The obstacle `t` [s] later, at constant velocity.
[[nodiscard]] Obstacle predicted(const Obstacle& obstacle, double t);

/// Whether outline and obstacle overlap. A round body may overlap by 3 cm: its constraint holds at
/// the nodes only, and Euler's step deviates from the arc by up to v ω Δt² / 2.
[[nodiscard]] bool touches(const Body& body, const Pose2& X_MB, const Obstacle& obstacle);

/// The obstacles, with those that the body touches at the start shrunk about their centres until it
/// no longer does: fitted shapes are larger than what they enclose, and a robot inside one must be
/// able to leave it. A motion that touches none of the result does not go deeper.
[[nodiscard]] std::vector<Obstacle> passable(const Body& body, const Motion& motion,
                                             std::span<const Obstacle> obstacles);

/// Whether the motion touches no obstacle for `duration` [s]. Checked along the exact arcs (of the
/// mean twist if the motors lag), at least once per centimetre of travel of any point of the body.
[[nodiscard]] bool is_clear(const Body& body, const Motion& motion,
                            std::span<const Obstacle> obstacles, double duration);

}  // namespace tandem
