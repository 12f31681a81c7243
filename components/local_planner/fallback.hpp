// SPDX-License-Identifier: Apache-2.0
// In: the last good plan and where the robot is. Out: the safest motion that needs no solver.
#pragma once

#include <algorithm>
#include <span>

#include "tandem/local_planner/motion_check.hpp"
#include "tandem/local_planner/plan.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {

/// Where a fallback starts: pose and twist at the moment the command acts.
struct Start {
  Pose2 X_MB;
  Twist2 command;     ///< in force
  double t0 = 0.0;    ///< [s]
  Twist2 moves = {};  ///< what the robot does then; not read without a lag
};

/// Rest of `plan` from t0 on, within acceleration limits of the command in force, one twist per
/// `period`; after the plan's end it brakes.
[[nodiscard]] Motion rest_of(const Plan& plan, const Start& start, double period,
                             const RobotParams& robot);

/// To rest along the current arc: w / v stays. The slower of v / a and w / α decides.
[[nodiscard]] Motion braking(const Start& start, double period, double a, double alpha);

/// The motion as motors drive that lag: seconds of rest commanded at its end until they stand.
[[nodiscard]] Motion with_lag(Motion motion, const MotorLag& lag, const Twist2& moves);

/// Seconds in which the motors all but reach a command.
[[nodiscard]] inline double coasting_time(const MotorLag& lag) {
  return 3.0 * std::max(lag.v, lag.w);
}

/// Seconds to rest from `twist` at the comfortable limits.
[[nodiscard]] double stopping_time(const Twist2& twist, const RobotParams& robot);

/// The motion as a plan: poses along the arcs.
[[nodiscard]] Plan to_plan(const Motion& motion, double t0);

/// The plan for a stick at rest: as hard as the robot can brake. By hand such a stick stops the
/// robot as soon as it can stop, and no method may take longer. The command asks for as much less
/// than the robot does as it can brake until the next command acts, not for zero, so that a stick
/// that rested only for a moment goes on from there. `delay`, `period` [s]: as in NmpcParams.
[[nodiscard]] Plan resting(const PlanRequest& request, double delay, double period,
                           const RobotParams& robot);

}  // namespace tandem
