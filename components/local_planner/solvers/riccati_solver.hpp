// SPDX-License-Identifier: Apache-2.0
// Riccati interior point method: solves an optimal control problem stage by stage, for speed.
#pragma once

#include <memory>

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// Primal-dual interior point method on the chain of stages, with a line-search filter, the exact
/// Hessian and a Riccati recursion (riccati.hpp). It has the same optimality conditions as
/// ipopt_solve and is ten times as fast as that with MA27, a hundred times with MUMPS. A guess with
/// multipliers starts at the final barrier parameter. A guess without, or one that turns out to be
/// far from the optimum, is solved with a decreasing barrier parameter.
///
/// Reuses its memory: no allocation once it has solved a problem of at least the same size. Equal
/// calls give equal results unless a deadline interrupts them.
class RiccatiSolver {
 public:
  RiccatiSolver();
  ~RiccatiSolver();
  RiccatiSolver(RiccatiSolver&&) noexcept;
  RiccatiSolver& operator=(RiccatiSolver&&) noexcept;

  /// Local minimum of `ocp` from `guess`, to an optimality error of 1e-4 at a barrier of 1e-4.
  /// Does not throw. The result is valid until the next call.
  const Solution& solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
