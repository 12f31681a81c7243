// SPDX-License-Identifier: Apache-2.0
// Types shared by all solvers: primal-dual point, limits, solution, solver kinds.
#pragma once

#include <chrono>
#include <span>
#include <string_view>
#include <vector>

namespace tandem {

/// Primal and dual point of an Ocp. An empty `lambda` means a cold start.
struct Iterate {
  std::vector<double> z;             ///< variables(ocp)
  std::vector<double> lambda;        ///< rows(ocp)
  std::vector<double> lower, upper;  ///< multipliers of the variables' bounds
};

/// A solution that need not be found again.
struct KnownSolution {
  Iterate point;  ///< the solution
  /// Distance of each stage's position at which a solve counts as having found it [m]; for headings
  /// the distance on a circle of kHeadingArm.
  double near = 0.0;
};
inline constexpr double kHeadingArm = 0.5;  ///< [m]

/// When to stop. The deadline is checked in every iteration.
struct SolveLimits {
  /// wall-clock limit
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  double iteration_time = 0.0;  ///< duration of an iteration in the previous solve [s]
  int iterations = 60;          ///< at most
  /// The structured solver stops near one of these; Ipopt does not look at them.
  std::span<const KnownSolution> known = {};
};

/// How a solve ended: converged, within the looser tolerance, out of time or iterations, near a
/// known solution, or none of these.
enum class SolveStatus { kConverged, kAcceptable, kTimeout, kKnown, kFailed };

/// The last iterate of a solve, and how it ended.
struct Solution {
  SolveStatus status = SolveStatus::kFailed;  ///< how it ended
  Iterate point = {};                         ///< its last iterate
  int iterations = 0;                         ///< of this solve
  double iteration_time = 0.0;                ///< mean of this solve [s]; 0 without iterations
};

/// Which solver solves the optimal control problem.
enum class SolverKind {
  kIpopt,       ///< the reference
  kStructured,  ///< Riccati interior point, ten to a hundred times as fast
  kCertified,   ///< structured, with its optimality checked, and Ipopt where that fails
};

/// What kCertified found out about a solution of the structured solver.
enum class Verdict {
  kUnverified,   ///< neither checked nor solved again, or Ipopt was interrupted
  kConfirmed,    ///< it satisfies the optimality conditions, or Ipopt found the same optimum
  kDisagreement  ///< Ipopt found another one, or the structured solver did not converge
};

/// The solver as the parameter `solver` writes it.
[[nodiscard]] const char* name(SolverKind kind);
/// The verdict in short, for logs and tables.
[[nodiscard]] const char* name(Verdict verdict);

/// Throws std::invalid_argument unless `text` is the name of a solver.
[[nodiscard]] SolverKind solver_named(std::string_view text);

}  // namespace tandem
