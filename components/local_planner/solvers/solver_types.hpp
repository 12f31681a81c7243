// SPDX-License-Identifier: Apache-2.0
// In: an optimal control problem, a guess, limits. Out: where a solver ended, primal and dual.
#pragma once

#include <chrono>
#include <string_view>
#include <vector>

namespace tandem {

/// Primal and dual point of an Ocp. `lambda` empty: no multipliers are known, a cold start.
struct Iterate {
  std::vector<double> z;             ///< variables(ocp)
  std::vector<double> lambda;        ///< rows(ocp)
  std::vector<double> lower, upper;  ///< multipliers of the variables' bounds
};

/// When to stop. The clock is read inside the iteration.
struct SolveLimits {
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  double iteration_time = 0.0;  ///< what an iteration took last time [s]
  int iterations = 60;
};

enum class SolveStatus { kConverged, kAcceptable, kTimeout, kFailed };

struct Solution {
  SolveStatus status = SolveStatus::kFailed;
  Iterate point = {};
  int iterations = 0;
  double iteration_time = 0.0;  ///< mean of this solve [s]; 0 if it had no iteration
};

enum class SolverKind {
  kIpopt,       ///< the reference
  kStructured,  ///< some hundred times as fast
  kCertified,   ///< structured, and Ipopt from its solution has to find the same
};

/// How a certified solution was judged.
enum class Verdict {
  kUnjudged,     ///< no second solver was asked, or its time was up
  kConfirmed,    ///< both end in the same optimum
  kDisagreement  ///< they do not, or the structured solver did not converge
};

[[nodiscard]] const char* name(SolverKind kind);
[[nodiscard]] const char* name(Verdict verdict);

/// Throws std::invalid_argument unless `text` is the name of a solver.
[[nodiscard]] SolverKind solver_named(std::string_view text);

}  // namespace tandem
