// SPDX-License-Identifier: Apache-2.0
// In: an optimal control problem and a guess. Out: where an interior point method on its stages
// ended, primal and dual.
#pragma once

#include <memory>

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/solvers/solver_types.hpp"

namespace tandem {

/// Primal-dual interior point method on the chain of stages: line-search filter, exact Hessian,
/// Riccati recursion (riccati.hpp). The same conditions as ipopt_solve's, some hundred times as
/// fast. A guess with multipliers is solved at the final barrier from the start; a guess without,
/// or one that turns out to be far away, with a falling barrier.
///
/// Keeps its memory: no allocation once it has solved a problem as large. Equal calls give equal
/// results as long as no deadline cuts them short.
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
