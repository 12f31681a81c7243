// SPDX-License-Identifier: Apache-2.0
// Solves an optimal control problem with Ipopt, the reference solver.
#pragma once

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// Solver of Ipopt's linear systems.
enum class LinearSolver {
  kStages,  ///< ipopt_linear_solver.hpp
  kMumps,   ///< general, with pivoting; takes about ten times as long
};

/// kStages if this Ipopt accepts it, else kMumps.
[[nodiscard]] LinearSolver best_linear_solver();

/// Local minimum of `ocp` from `guess`, to an optimality error of 1e-4 at a barrier of 1e-4.
///
/// With kStages each thread caches Ipopt's setup for each structure (pairs per stage, bounds) and
/// reuses it when the structure recurs; threads do not wait for each other. A warm start that has
/// not finished after 40 iterations counts as misleading: the solve restarts from `guess.z` alone.
/// MUMPS is used if a variable's bounds coincide, and after a failure.
///
/// With kMumps one solve runs at a time per process: MUMPS under Ipopt 3.11.9 is not thread safe,
/// neither while solving nor while it is built or destroyed. Other threads wait, at most until
/// their deadline.
[[nodiscard]] Solution ipopt_solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits,
                                   LinearSolver linear = best_linear_solver());

}  // namespace tandem
