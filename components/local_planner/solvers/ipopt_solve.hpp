// SPDX-License-Identifier: Apache-2.0
// In: an optimal control problem and a guess. Out: where Ipopt ended, primal and dual.
#pragma once

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// What solves Ipopt's linear systems.
enum class LinearSolver {
  kStages,  ///< ipopt_linear_solver.hpp
  kMumps,   ///< general, with pivoting: some ten times as long
};

/// kStages where this Ipopt lets it in, else kMumps.
[[nodiscard]] LinearSolver best_linear_solver();

/// Local minimum of `ocp` from `guess`, to an optimality error of 1e-4 at a barrier of 1e-4.
///
/// With kStages each thread keeps what Ipopt sets up for a structure (obstacles per stage, bounds)
/// and uses it again when that returns; threads do not wait for each other. A warm start that has
/// not ended after 40 iterations is taken for a misleading one: the rest is solved from `guess.z`
/// alone. MUMPS takes over where bounds meet, and after a failure.
///
/// With kMumps one solve at a time per process: MUMPS under Ipopt 3.11.9 is not thread safe,
/// neither while solving nor while it is built or destroyed. Others wait, at most until their
/// deadline.
[[nodiscard]] Solution ipopt_solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits,
                                   LinearSolver linear = best_linear_solver());

}  // namespace tandem
