// SPDX-License-Identifier: Apache-2.0
// Motions that need no solver: the rest of the last plan, and braking.
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
  Twist2 moves = {};  ///< actual twist at t0; not read without a lag
};

/// Rest of `plan` from t0 on, one twist per `period` [s], reached from the command in force within
/// the acceleration limits; brakes after the plan's end.
[[nodiscard]] Motion rest_of(const Plan& plan, const Start& start, double period,
                             const RobotParams& robot);

/// Brakes to rest along the current arc (w / v is kept) in max(|v| / a, |w| / α). `a` [m/s²],
/// `alpha` [rad/s²], `period` [s] per twist.
[[nodiscard]] Motion braking(const Start& start, double period, double a, double alpha);

/// The motion driven by lagging motors: zero twists are appended until the motors stand. `moves`:
/// actual twist at the start.
[[nodiscard]] Motion with_lag(Motion motion, const MotorLag& lag, const Twist2& moves);

/// Time in which the motors reach a command to within 5 % [s].
[[nodiscard]] inline double coasting_time(const MotorLag& lag) {
  return 3.0 * std::max(lag.v, lag.w);
}

/// Time to rest from `twist` at a_max and alpha_max [s].
[[nodiscard]] double stopping_time(const Twist2& twist, const RobotParams& robot);

/// The motion as a plan that starts at t0 [s], with poses along the arcs.
[[nodiscard]] Plan to_plan(const Motion& motion, double t0);

/// The plan for a stick at rest: braking as hard as the robot can, because shared control must not
/// stop later than manual control. The command is the speed the robot can brake to before the next
/// command acts, not zero, so that driving resumes from there after a brief rest of the stick.
/// `delay`, `period` [s]: as in NmpcParams.
[[nodiscard]] Plan resting(const PlanRequest& request, double delay, double period,
                           const RobotParams& robot);

}  // namespace tandem
