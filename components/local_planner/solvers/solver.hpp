// SPDX-License-Identifier: Apache-2.0
// In: an optimal control problem, a guess, limits. Out: the chosen solver's answer.
#pragma once

#include "tandem/local_planner/solvers/riccati_solver.hpp"

namespace tandem {

struct Answer {
  Solution solution = {};  ///< iterations: of all solvers; iteration_time: Ipopt's, if it was asked
  SolverKind by = SolverKind::kIpopt;  ///< kIpopt or kStructured
  Verdict verdict = Verdict::kUnjudged;
  int effort = 0;  ///< what it cost, in iterations of Ipopt
};

/// Solves with the solver of its kind. Iteration limits are Ipopt's: the structured solver, some
/// hundred times as fast, gets more of its own.
class Solver {
 public:
  explicit Solver(SolverKind kind) : kind_{kind} {}

  /// Does not throw. Certified: where the two disagree the better point is taken, where the
  /// structured one does not converge Ipopt starts from the guess.
  [[nodiscard]] Answer solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits);

 private:
  [[nodiscard]] Answer certify(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits);
  [[nodiscard]] const Solution& structured(const Ocp& ocp, const Iterate& guess,
                                           const SolveLimits& limits);

  SolverKind kind_;
  RiccatiSolver structured_;
};

}  // namespace tandem
