// SPDX-License-Identifier: Apache-2.0
// Searches one planning cycle's best motion: solves from several guesses within the budgets.
#pragma once

#include <chrono>
#include <optional>

#include "tandem/local_planner/cycle.hpp"
#include "tandem/local_planner/solvers/solver.hpp"
#include "tandem/local_planner/warm_start.hpp"

namespace tandem {

/// Age up to which a plan is a warm start or a fallback [s].
inline constexpr double kLongestReuse = 1.0;
/// Part of time_budget that is left for the check and the fallback [s].
inline constexpr double kReserve = 0.003;

/// Work done in one cycle.
struct SearchEffort {
  int iterations = 0, guesses = 0, solves = 0;
  int confirmed = 0, disagreements = 0;  ///< solves by the verifier's verdict
};

/// Solves each cycle's problem from the last solution and from other guesses. The budgets are those
/// of the cycle's parameters. Keeps the last solution and estimates of the solve time.
class CandidateSearch {
 public:
  using Clock = std::chrono::steady_clock;

  explicit CandidateSearch(SolverKind kind);

  /// The best motion found; check it with is_usable(). `started`: begin of the cycle, from which
  /// time_budget counts.
  [[nodiscard]] Candidate find(const Cycle& cycle, Clock::time_point started);
  /// Whether the motion may be executed. One cut short by the time limit must not cost more than
  /// the last solution, shifted.
  [[nodiscard]] bool is_usable(const Cycle& cycle, const Candidate& best) const;
  /// Keeps the solution as the next warm start, unless it failed or three in a row timed out.
  void remember(const Cycle& cycle, const Candidate& best);
  /// Makes the next search start cold.
  void forget() { last_.reset(); }
  /// Like forget(); also begins the list of guesses and the count of time-outs again.
  void reset();

  /// Of the last find().
  [[nodiscard]] const SearchEffort& effort() const { return effort_; }

 private:
  [[nodiscard]] double elapsed(const Cycle& cycle) const { return cycle.start.t0 - last_->t0; }
  [[nodiscard]] bool is_continued(const Cycle& cycle) const;
  [[nodiscard]] bool has_time_for_another(const NmpcParams& params, double share) const;
  [[nodiscard]] SolveLimits solve_limits(const NmpcParams& params) const;

  [[nodiscard]] Candidate first_candidate(const Cycle& cycle);
  [[nodiscard]] Candidate attempt(const Cycle& cycle, const Forecast& guess, bool warm);
  [[nodiscard]] Candidate solve(Solver& solver, const Cycle& cycle, Ocp ocp, const Iterate& guess);
  void explore(const Cycle& cycle, Candidate& best);
  void note(const Candidate& candidate);
  void certify(const Cycle& cycle, Candidate& best);

  Solver explorer_;                 // solves from every guess
  std::optional<Solver> verifier_;  // verifies the best solution; only with kCertified
  std::optional<Solved> last_;      // warm start
  double iteration_time_ = 0.0;     // smoothed [s]
  double solve_time_ = 0.0;         // of one solve, smoothed [s]
  int timeouts_ = 0;                // consecutive
  unsigned turn_ = 0;               // index of the next constant twist to start from

  // Of the current cycle.
  Clock::time_point started_;
  SearchEffort effort_;
  int budgeted_iterations_ = 0;       // as counted against iteration_budget
  std::vector<KnownSolution> known_;  // that other guesses need not find again
};

}  // namespace tandem
