// SPDX-License-Identifier: Apache-2.0
// Builds the solver's initial iterate from a motion or from the last solution.
#pragma once

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/reference.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// A solution, the problem it solves and the time of that problem's stage 0.
struct Solved {
  Ocp ocp;
  Iterate point;
  double t0 = 0.0;  ///< [s]
};

/// Primal point that follows the motion, with slacks near zero, without multipliers.
[[nodiscard]] Iterate trajectory(const Ocp& ocp, const Forecast& motion);

/// trajectory() with slacks that satisfy the pairs of `ocp`, except for the speed-dependent margin
/// of rows (4).
[[nodiscard]] Iterate cold_start(const Ocp& ocp, const Forecast& motion);

/// Pose of a solution `elapsed` [s] after its stage 0; the last pose after its end.
[[nodiscard]] Pose2 shifted_start(const Solved& last, double elapsed);

/// Motion of a solution that began `elapsed` [s] ago, for the stages of `ocp` and interpolated in
/// time. After the solution's end its last twist is held.
[[nodiscard]] Forecast shifted_motion(const Solved& last, double elapsed, const Ocp& ocp);

/// Primal and dual point of the last solution, shifted by `elapsed` [s]. Rows (4) are matched by
/// disc and obstacle; a new row's multiplier follows from its clearance and the barrier parameter.
[[nodiscard]] Iterate warm_start(const Solved& last, double elapsed, const Ocp& ocp);

}  // namespace tandem
