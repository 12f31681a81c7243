// SPDX-License-Identifier: Apache-2.0
// Solves an optimal control problem with the configured solver.
#pragma once

#include "tandem/local_planner/solvers/riccati_solver.hpp"

namespace tandem {

struct Answer {
  Solution solution = {};  ///< iterations of all solvers; iteration_time of Ipopt if it ran
  SolverKind by = SolverKind::kIpopt;  ///< solver of `solution`: kIpopt or kStructured
  Verdict verdict = Verdict::kUnverified;
  int effort = 0;  ///< computing effort, in Ipopt iterations
};

/// Runs the solver or solvers of a SolverKind. Iteration limits count Ipopt iterations; the faster
/// structured solver gets 30 times as many, but at most 200.
class Solver {
 public:
  explicit Solver(SolverKind kind) : kind_{kind} {}

  /// Does not throw. With kCertified, a solution of the structured solver is confirmed by its
  /// optimality conditions, which Ipopt would check first and then stop: this takes an eighth of
  /// the time. Where they do not hold, and for every 20th solution, Ipopt solves from the
  /// structured solver's solution, or from the guess if that did not converge; if the two disagree,
  /// the better point is returned.
  [[nodiscard]] Answer solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits);

  /// Whether kCertified confirms the point by its optimality conditions. False at first and after
  /// 19 points, until Ipopt has solved.
  [[nodiscard]] bool confirms(const Ocp& ocp, const Iterate& point);

 private:
  [[nodiscard]] Answer certify(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits);
  [[nodiscard]] const Solution& structured(const Ocp& ocp, const Iterate& guess,
                                           const SolveLimits& limits);

  SolverKind kind_;
  RiccatiSolver structured_;
  static constexpr int kSpotCheck = 20;  // of so many solutions Ipopt solves one
  int confirmed_ = kSpotCheck;           // points since Ipopt solved; at first Ipopt is due
};

}  // namespace tandem
