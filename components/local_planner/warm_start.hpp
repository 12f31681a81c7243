// SPDX-License-Identifier: Apache-2.0
// In: a motion, or the last solution. Out: an iterate to start the next solve from.
#pragma once

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/reference.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// A solution with the problem it solves and the time of that problem's stage 0.
struct Solved {
  Ocp ocp;
  Iterate point;
  double t0 = 0.0;  ///< [s]
};

/// Primal point that follows the motion, slacks as large as the clearances of ocp's pairs ask for,
/// not counting what rows (4) grow by with speed; no multipliers.
[[nodiscard]] Iterate cold_start(const Ocp& ocp, const Forecast& motion);

/// Pose of a solution `elapsed` seconds after its stage 0; past its end the last one.
[[nodiscard]] Pose2 shifted_start(const Solved& last, double elapsed);

/// Poses at the ends of the stages and twists of a solution that began `elapsed` seconds ago,
/// interpolated in time; past its end it stays in the last stage.
[[nodiscard]] Forecast shifted_motion(const Solved& last, double elapsed, const Ocp& ocp);

/// Primal and dual point of the last solution, `elapsed` seconds later. Rows (4) are matched by
/// disc and obstacle; new ones get the multiplier that the barrier gives to their clearance.
[[nodiscard]] Iterate warm_start(const Solved& last, double elapsed, const Ocp& ocp);

}  // namespace tandem
