// SPDX-License-Identifier: Apache-2.0
// In: a motion and the obstacles. Out: whether the robot's true outline stays clear of them.
#pragma once

#include <span>
#include <vector>

#include "tandem/model/footprint.hpp"
#include "tandem/model/motor_lag.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// The robot as the planner sees it: discs in the programme, the outline in the check.
struct Body {
  Footprint footprint;
  std::vector<Disc> discs;
  bool round = false;  ///< the robot is its first disc, as in Devalla's scripts; no outline
};

/// Radius of the body's largest disc [m]: what the widest part needs. Discs of one part are equal.
[[nodiscard]] double largest_radius(const Body& body);

/// Twists commanded for dt each, from X_MB on, starting `start` seconds after the obstacles' time.
struct Motion {
  Pose2 X_MB;
  double start = 0.0;
  double dt = 0.25;
  std::vector<Twist2> twist = {};
  MotorLag lag = {};
  Twist2 moves = {};  ///< the twist at X_MB; not read without a lag
};

/// The obstacle where it will be in `t` seconds.
[[nodiscard]] Obstacle predicted(const Obstacle& obstacle, double t);

/// Whether outline and obstacle overlap. A round body may overlap by 3 cm: its constraint holds at
/// the nodes only, Euler's step leaves the arc by up to v ω Δt² / 2, and no outline is inside it.
[[nodiscard]] bool touches(const Body& body, const Pose2& X_MB, const Obstacle& obstacle);

/// The obstacles, those that the body touches at the start shrunk about their centres until it
/// no longer does: fitted shapes are larger than what they hold, and a robot inside one has to
/// get out. A motion that touches none of the result does not go deeper.
[[nodiscard]] std::vector<Obstacle> passable(const Body& body, const Motion& motion,
                                             std::span<const Obstacle> obstacles);

/// Whether the motion touches no obstacle for `duration` seconds, checked along the exact arcs (of
/// the mean twist, where the motors lag) at least every centimetre of travel of any point of the
/// body.
[[nodiscard]] bool is_clear(const Body& body, const Motion& motion,
                            std::span<const Obstacle> obstacles, double duration);

}  // namespace tandem
