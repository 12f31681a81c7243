// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/candidate_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tandem/local_planner/guesses.hpp"

namespace tandem {
namespace {

constexpr double kSurprise = 0.3;  // [m], [rad] deviation that makes the last solution useless
constexpr double kExplores = 0.3;  // share of the budget within which other guesses may start
// A motion from another guess replaces the last plan if its value is below this share of the last
// plan's; the second factor holds if the last plan is poor.
constexpr double kBetter = 0.9;
constexpr double kBetterThanPoor = 0.98;

// A solve that comes this close to a known solution, and within this share of its length, is taken
// to end in it.
constexpr double kNear = 0.1;  // [m]
constexpr double kNearShare = 0.1;

double travel(const Forecast& motion) {
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < motion.X_MB.size(); ++k) {
    const Pose2 &from = motion.X_MB[k], &to = motion.X_MB[k + 1];
    length +=
        (to.position() - from.position()).norm() + kHeadingArm * std::abs(to.theta - from.theta);
  }
  return length;
}

bool is_solved(const Candidate& candidate) {
  const SolveStatus status = candidate.solution.status;
  return status != SolveStatus::kFailed && status != SolveStatus::kKnown;
}

bool is_optimal(const Candidate& candidate) {
  const SolveStatus status = candidate.solution.status;
  return status == SolveStatus::kConverged || status == SolveStatus::kAcceptable;
}

double seconds_since(CandidateSearch::Clock::time_point start) {
  return std::chrono::duration<double>(CandidateSearch::Clock::now() - start).count();
}

}  // namespace

CandidateSearch::CandidateSearch(SolverKind kind)
    : explorer_{kind == SolverKind::kCertified ? SolverKind::kStructured : kind} {
  if (kind == SolverKind::kCertified) verifier_.emplace(kind);
}

Candidate CandidateSearch::find(const Cycle& cycle, Clock::time_point started) {
  started_ = started;
  effort_ = {};
  known_.clear();
  budgeted_iterations_ = 0;
  if (last_ && !is_continued(cycle)) last_.reset();
  Candidate best = first_candidate(cycle);
  explore(cycle, best);
  certify(cycle, best);
  return best;
}

void CandidateSearch::reset() {
  last_.reset();
  timeouts_ = 0;
  turn_ = 0;
}

// Whether the last solution is recent and the robot is where it predicted.
bool CandidateSearch::is_continued(const Cycle& cycle) const {
  if (!(elapsed(cycle) >= 0.0 && elapsed(cycle) < kLongestReuse)) return false;
  const Pose2 expected = shifted_start(*last_, elapsed(cycle));
  return (expected.position() - cycle.start.X_MB.position()).norm() < kSurprise &&
         std::abs(wrap_angle(expected.theta - cycle.start.X_MB.theta)) < kSurprise;
}

SolveLimits CandidateSearch::solve_limits(const NmpcParams& params) const {
  SolveLimits limits{
      .iteration_time = iteration_time_, .iterations = params.max_iterations, .known = known_};
  if (params.iteration_budget > 0)
    limits.iterations =
        std::clamp(params.iteration_budget - budgeted_iterations_, 1, params.max_iterations);
  if (params.time_budget > 0.0)
    limits.deadline = started_ + std::chrono::duration_cast<Clock::duration>(
                                     std::chrono::duration<double>(params.time_budget - kReserve));
  return limits;
}

// Whether another solve is expected to finish within that share of the budget.
bool CandidateSearch::has_time_for_another(const NmpcParams& params, double share) const {
  if (params.iteration_budget > 0 && budgeted_iterations_ >= share * params.iteration_budget)
    return false;
  if (params.time_budget <= 0.0) return true;
  return seconds_since(started_) + 1.2 * solve_time_ < share * (params.time_budget - kReserve);
}

Candidate CandidateSearch::solve(Solver& solver, const Cycle& cycle, Ocp ocp,
                                 const Iterate& guess) {
  const auto before = Clock::now();
  Answer answer = solver.solve(ocp, guess, solve_limits(cycle.params));
  Solution& solution = answer.solution;
  ++effort_.solves;
  effort_.iterations += solution.iterations;
  budgeted_iterations_ += answer.effort;
  effort_.confirmed += answer.verdict == Verdict::kConfirmed ? 1 : 0;
  effort_.disagreements += answer.verdict == Verdict::kDisagreement ? 1 : 0;
  if (solution.status == SolveStatus::kKnown)  // tells nothing of how long a solve takes
    return {.solution = std::move(solution), .solver = answer.by};
  // Smoothed and bounded, so that one preempted iteration cannot keep later solves from starting.
  // A solve that had no time for an iteration lets the estimate decay.
  iteration_time_ = std::min(0.7 * iteration_time_ + 0.3 * solution.iteration_time,
                             0.1 * cycle.params.time_budget);
  const double took = seconds_since(before);
  solve_time_ = solve_time_ > 0.0 ? 0.8 * solve_time_ + 0.2 * took : took;
  if (solution.status == SolveStatus::kFailed) solution.point = guess;

  Forecast motion;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k)
    motion.twist.push_back(twist_of(ocp, solution.point.z, k));
  Candidate out = rate(cycle, std::move(ocp), motion);
  out.solution = std::move(solution);
  out.solver = answer.by;
  out.verdict = answer.verdict;
  return out;
}

// Solves from a guess, and again if the solution violates the margin of a pair left out.
Candidate CandidateSearch::attempt(const Cycle& cycle, const Forecast& guess, bool warm) {
  Ocp ocp = problem(cycle, guess);
  const Iterate point =
      warm ? warm_start(*last_, elapsed(cycle), ocp) : cold_start(ocp, within_limits(ocp, guess));
  Candidate out = solve(explorer_, cycle, std::move(ocp), point);
  if (!is_solved(out) || !left_out_a_pair(out) || !has_time_for_another(cycle.params, 1.0))
    return out;
  ocp = problem(cycle, out.motion);
  const Solved so_far{out.ocp, out.solution.point, cycle.start.t0};
  return solve(explorer_, cycle, ocp, warm_start(so_far, 0.0, ocp));
}

Candidate CandidateSearch::first_candidate(const Cycle& cycle) {
  ++effort_.guesses;
  if (!last_) return attempt(cycle, cold_guess(cycle), false);
  Candidate out = attempt(cycle, shifted_motion(*last_, elapsed(cycle), cycle.base), true);
  const bool failed = out.solution.status == SolveStatus::kFailed ||
                      out.solution.status == SolveStatus::kTimeout || !is_clear(cycle, out);
  if (!failed || !has_time_for_another(cycle.params, 1.0)) return out;
  ++effort_.guesses;
  Candidate cold = attempt(cycle, cold_guess(cycle), false);
  const bool wins = is_clear(cycle, cold) && (!is_clear(cycle, out) || cold.value < out.value);
  return wins ? cold : out;
}

// Solves from other guesses while time permits. The last plan is replaced only by a clearly better
// motion, so that the robot does not alternate between two ways of nearly equal value. Nearly all
// guesses lead to a solution that is known: a solve stops when it comes near one, and guesses that
// plainly lead to `best` are skipped unless it is poor.
void CandidateSearch::explore(const Cycle& cycle, Candidate& best) {
  if (cycle.params.extra_guesses == 0) return;
  const bool usable = best.solution.status != SolveStatus::kFailed && is_clear(cycle, best);
  const bool poor = !usable || is_poor(cycle, best);
  const bool may_skip = !poor && is_optimal(best);
  const double to_beat = usable ? (poor ? kBetterThanPoor : kBetter) * best.value : kUnbounded;
  const unsigned arcs = static_cast<unsigned>(cycle.params.extra_guesses) * (poor ? 3 : 1);
  std::optional<Candidate> found;
  std::vector<Forecast> others = other_guesses(cycle, turn_, arcs);
  effort_.guesses += static_cast<int>(others.size());
  if (usable) note(best);
  for (const Forecast& guess : most_promising_first(cycle, std::move(others))) {
    if (!has_time_for_another(cycle.params, kExplores)) break;
    if (may_skip && is_alike(guess, best.motion, cycle.body, cycle.request.obstacles, cycle.limits))
      continue;
    Candidate other = attempt(cycle, guess, false);
    if (!is_solved(other) || !is_clear(cycle, other)) continue;
    note(other);
    if (other.value < (found ? found->value : to_beat)) found = std::move(other);
  }
  known_.clear();
  turn_ += arcs;
  if (found) best = std::move(*found);
}

// Keeps a solution for the solves from other guesses. A point that is no optimum is not kept: the
// way to the optimum may lead past it.
void CandidateSearch::note(const Candidate& candidate) {
  if (!is_optimal(candidate)) return;
  known_.push_back(
      {candidate.solution.point, std::min(kNear, kNearShare * travel(candidate.motion))});
}

// Unless the verifier confirms the best solution as it is, solves again from it with both solvers.
void CandidateSearch::certify(const Cycle& cycle, Candidate& best) {
  if (!verifier_) return;
  if (best.solution.status == SolveStatus::kConverged &&
      verifier_->confirms(best.ocp, best.solution.point)) {
    best.verdict = Verdict::kConfirmed;
    ++effort_.confirmed;
    return;
  }
  Candidate verified = solve(*verifier_, cycle, best.ocp, best.solution.point);
  best.verdict = verified.verdict;
  if (is_clear(cycle, verified) || !is_clear(cycle, best)) best = std::move(verified);
}

void CandidateSearch::remember(const Cycle& cycle, const Candidate& best) {
  const SolveStatus status = best.solution.status;
  timeouts_ = status == SolveStatus::kTimeout ? timeouts_ + 1 : 0;
  if (status != SolveStatus::kFailed && timeouts_ < 3)
    last_ = Solved{best.ocp, best.solution.point, cycle.start.t0};
  else
    last_.reset();
}

bool CandidateSearch::is_usable(const Cycle& cycle, const Candidate& best) const {
  if (best.solution.status == SolveStatus::kFailed || !is_clear(cycle, best)) return false;
  if (best.solution.status != SolveStatus::kTimeout || !last_) return true;
  const Forecast before = shifted_motion(*last_, elapsed(cycle), best.ocp);
  return best.cost <= rate(cycle, best.ocp, before).cost;
}

}  // namespace tandem
