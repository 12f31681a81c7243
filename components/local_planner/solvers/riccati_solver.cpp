// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/riccati_solver.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/local_planner/solvers/kkt_system.hpp"
#include "tandem/local_planner/solvers/optimality.hpp"

namespace tandem {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kAcceptable = 1e-3;  // an optimality error below this suffices …
constexpr int kAcceptableCount = 5;   // … for this many iterations in a row
constexpr double kColdBarrier = 1e-2, kRaisedBarrier = 1e-3;  // times the slack weight
constexpr double kColdPush = 1e-2, kWarmPush = 1e-8;  // initial relative distance from bounds
constexpr double kShort = 0.1;  // a step cut below this fraction makes no progress …
constexpr int kShortCount = 4;  // … if this many occur in a row
constexpr int kMaxAtEnd = 20;   // iterations at the final barrier after which it counts as stuck
constexpr int kRecentrings = 3;
constexpr int kBacktracks = 20;

double seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

std::size_t pair_count(const Ocp& ocp) {
  std::size_t count = 0;
  for (const Stage& stage : ocp.stages) count += stage.pairs.size();
  return count;
}

// The interior point method for stages that pass on n states.
template <int n>
struct Chain {
  const Solution& solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits);

  Box box;
  IpIterate<n> now, trial;
  Multipliers<n> multipliers;
  KktSystem<n> system;
  Step<n> step;
  LineSearchFilter filter;
  double mu = kFinalBarrier;
  int short_steps = 0;  // in a row
  int at_end = 0;       // iterations in a row at the final barrier
  int recentrings = 0;
  int acceptable = 0;  // iterations in a row
  Solution out;

  bool start(const Ocp& ocp, const Iterate& guess);
  void push_inside(const std::vector<double>& z, double push);
  void take_multipliers(const Iterate& guess);
  void centre(const Ocp& ocp, double barrier);
  void begin_from_here(const Ocp& ocp);

  [[nodiscard]] bool is_near(const Iterate& known, double distance) const;
  bool is_done(const SolveLimits& limits, Clock::time_point started);
  void lower_barrier(const Ocp& ocp);
  bool advance_point(const Ocp& ocp);
  bool search_line(const Ocp& ocp);
  void take_step(double alpha);
  void write_point();
};

// Returns false if the guess or the bounds are unusable.
template <int n>
bool Chain<n>::start(const Ocp& ocp, const Iterate& guess) {
  const std::size_t stages = ocp.stages.size(), pairs = pair_count(ocp);
  now.resize(stages, pairs);
  now.set_problem(ocp);
  trial.resize(stages, pairs);
  trial.set_problem_of(now);
  multipliers.resize(stages, pairs);
  system.resize(stages, pairs);
  system.reset();
  step.resize(stages, pairs);
  short_steps = recentrings = acceptable = at_end = 0;
  const std::size_t size = block_of(n) * stages;
  if (guess.z.size() != size || !box.set(ocp)) return false;
  if (!std::all_of(guess.z.begin(), guess.z.end(), [](double z) { return std::abs(z) < 1e9; }))
    return false;

  const bool warm = guess.lambda.size() == equalities_of(n) * stages + pairs &&
                    guess.lower.size() == size && guess.upper.size() == size;
  if (warm) {
    mu = kFinalBarrier;
    push_inside(guess.z, kWarmPush);
    now.set_slacks(ocp, kWarmPush);
    take_multipliers(guess);
  } else {
    now.z = guess.z;
    centre(ocp, kColdBarrier * ocp.slack_weight);
    std::fill(multipliers.pi.begin(), multipliers.pi.end(), ChainState<n>::Zero());
    std::fill(multipliers.lambda.begin(), multipliers.lambda.end(), Eigen::Vector2d::Zero());
  }
  begin_from_here(ocp);
  return std::isfinite(now.infeasibility) && std::isfinite(now.merit(mu).barrier);
}

template <int n>
void Chain<n>::push_inside(const std::vector<double>& z, double push) {
  for (std::size_t i = 0; i < z.size(); ++i) {
    const double lower = box.lower[i], upper = box.upper[i], room = upper - lower;
    now.z[i] = std::clamp(z[i], lower + push * std::min(std::max(1.0, std::abs(lower)), room),
                          upper - push * std::min(std::max(1.0, std::abs(upper)), room));
  }
}

template <int n>
void Chain<n>::take_multipliers(const Iterate& guess) {
  const std::size_t stages = multipliers.pi.size();
  multipliers.lower = guess.lower;
  multipliers.upper = guess.upper;
  for (std::size_t k = 0; k < stages; ++k) {
    const double* row = &guess.lambda[equalities_of(n) * k];
    multipliers.lambda[k] = {row[0], row[1]};
    for (int i = 0; i < n; ++i) multipliers.pi[k][i] = -row[2 + i];
  }
  for (std::size_t i = 0; i < multipliers.y.size(); ++i)
    multipliers.y[i] = -guess.lambda[equalities_of(n) * stages + i];
}

// Moves the point well inside all bounds and sets the multipliers of bounds and rows (4) so that
// each product distance · multiplier is mu.
template <int n>
void Chain<n>::centre(const Ocp& ocp, double barrier) {
  mu = std::max(kFinalBarrier, barrier);
  push_inside(now.z, kColdPush);
  now.set_slacks(ocp, kColdPush);
  for (std::size_t i = 0; i < now.z.size(); ++i) {
    multipliers.lower[i] = mu / (now.z[i] - box.lower[i]);
    multipliers.upper[i] = mu / (box.upper[i] - now.z[i]);
  }
  for (std::size_t i = 0; i < now.t.size(); ++i) multipliers.y[i] = mu / now.t[i];
}

template <int n>
void Chain<n>::begin_from_here(const Ocp& ocp) {
  now.evaluate(ocp, box);
  filter.reset(now.infeasibility);
  system.condense(ocp, box, now, mu, multipliers);
}

template <int n>
bool Chain<n>::is_near(const Iterate& known, double distance) const {
  if (known.z.size() != now.z.size()) return false;
  const double d2 = distance * distance;
  for (std::size_t k = 0; k < now.z.size(); k += block_of(n)) {
    const double dx = now.z[k + kX] - known.z[k + kX], dy = now.z[k + kY] - known.z[k + kY];
    const double turn = kHeadingArm * (now.z[k + kTheta] - known.z[k + kTheta]);
    if (dx * dx + dy * dy > d2 || turn * turn > d2) return false;
  }
  return true;
}

// Sets the status. Returns true on convergence, near a known solution, after enough acceptable
// iterations, at the iteration limit, or if two more iterations might miss the deadline.
template <int n>
bool Chain<n>::is_done(const SolveLimits& limits, Clock::time_point started) {
  const double error = system.error(kFinalBarrier);
  if (error <= kTolerance && system.complementarity(kFinalBarrier) <= kTolerance) {
    out.status = SolveStatus::kConverged;
    return true;
  }
  for (const KnownSolution& known : limits.known)
    if (is_near(known.point, known.near)) {
      out.status = SolveStatus::kKnown;
      return true;
    }
  acceptable = error <= kAcceptable ? acceptable + 1 : 0;
  out.status = acceptable > 0 ? SolveStatus::kAcceptable : SolveStatus::kTimeout;
  if (acceptable == kAcceptableCount || out.iterations >= limits.iterations) return true;
  if (limits.deadline == Clock::time_point::max()) return false;
  const Clock::time_point clock = Clock::now();
  const double each =
      out.iterations > 0 ? seconds(clock - started) / out.iterations : limits.iteration_time;
  return clock + std::chrono::duration<double>(2.0 * each) >= limits.deadline;
}

// Ipopt's monotone rule: lowers the barrier parameter once the error is of its size.
template <int n>
void Chain<n>::lower_barrier(const Ocp& ocp) {
  const double before = mu;
  while (mu > kFinalBarrier && system.error(mu) <= 10.0 * mu)
    mu = std::max(kFinalBarrier, std::min(0.2 * mu, std::pow(mu, 1.5)));
  if (mu == before) return;
  filter.reset(now.infeasibility);
  system.condense(ocp, box, now, mu, multipliers);
}

// One iteration; returns false if there is no acceptable step. Repeatedly short steps, or many
// iterations at the final barrier, mean that the point is too close to its bounds for so low a
// barrier: it is recentred at a higher one.
template <int n>
bool Chain<n>::advance_point(const Ocp& ocp) {
  lower_barrier(ocp);
  if (!system.solve(ocp, now, mu, multipliers, step)) return false;
  const bool moved = search_line(ocp);
  const bool is_short = !moved || std::min(step.alpha_primal, step.alpha_dual) < kShort;
  short_steps = is_short ? short_steps + 1 : 0;
  at_end = mu == kFinalBarrier ? at_end + 1 : 0;
  const bool is_stuck = !moved || short_steps == kShortCount || at_end > kMaxAtEnd;
  if (is_stuck && recentrings < kRecentrings) {
    ++recentrings;
    short_steps = 0;
    at_end = 0;
    centre(ocp, std::max(mu, kRaisedBarrier * ocp.slack_weight));
    begin_from_here(ocp);
    return true;
  }
  if (moved) system.condense(ocp, box, now, mu, multipliers);
  return moved;
}

template <int n>
bool Chain<n>::search_line(const Ocp& ocp) {
  const Merit merit = now.merit(mu);
  double alpha = step.alpha_primal;
  for (int i = 0; i < kBacktracks; ++i, alpha *= 0.5) {
    for (std::size_t j = 0; j < now.z.size(); ++j) trial.z[j] = now.z[j] + alpha * step.z[j];
    for (std::size_t j = 0; j < now.t.size(); ++j) trial.t[j] = now.t[j] + alpha * step.t[j];
    trial.evaluate(ocp, box);
    if (!filter.accepts(merit, trial.merit(mu), alpha, step.slope)) continue;
    take_step(alpha);
    return true;
  }
  return false;
}

template <int n>
void Chain<n>::take_step(double alpha) {
  std::swap(now, trial);
  Multipliers<n>& m = multipliers;
  for (std::size_t k = 0; k < m.pi.size(); ++k) {
    m.pi[k] += alpha * (step.chain[k].pi - m.pi[k]);
    m.lambda[k] += alpha * (step.chain[k].lambda - m.lambda[k]);
  }
  for (std::size_t i = 0; i < m.lower.size(); ++i) {
    m.lower[i] += step.alpha_dual * step.lower[i];
    m.upper[i] += step.alpha_dual * step.upper[i];
  }
  for (std::size_t i = 0; i < m.y.size(); ++i) m.y[i] += step.alpha_dual * step.y[i];
}

template <int n>
void Chain<n>::write_point() {
  Iterate& point = out.point;
  point.z = now.z;
  point.lower = multipliers.lower;
  point.upper = multipliers.upper;
  for (std::size_t i = 0; i < now.z.size(); ++i) {
    if (box.lower[i] <= -Box::kFar) point.lower[i] = 0.0;
    if (box.upper[i] >= Box::kFar) point.upper[i] = 0.0;
  }
  const std::size_t stages = now.stages.size();
  point.lambda.resize(equalities_of(n) * stages + now.t.size());
  for (std::size_t k = 0; k < stages; ++k) {
    double* row = &point.lambda[equalities_of(n) * k];
    row[0] = multipliers.lambda[k].x();
    row[1] = multipliers.lambda[k].y();
    for (int i = 0; i < n; ++i) row[2 + i] = -multipliers.pi[k][i];
  }
  for (std::size_t i = 0; i < now.t.size(); ++i)
    point.lambda[equalities_of(n) * stages + i] = -multipliers.y[i];
}

template <int n>
const Solution& Chain<n>::solve(const Ocp& ocp, const Iterate& guess, const SolveLimits& limits) {
  const Clock::time_point started = Clock::now();
  out.status = SolveStatus::kFailed;
  out.iterations = 0;
  out.iteration_time = 0.0;
  filter.reserve(static_cast<std::size_t>(limits.iterations) + 1);
  if (!start(ocp, guess)) return out;
  while (!is_done(limits, started)) {
    if (!advance_point(ocp)) {
      if (out.status != SolveStatus::kAcceptable) out.status = SolveStatus::kFailed;
      break;
    }
    ++out.iterations;
  }
  if (out.iterations > 0) out.iteration_time = seconds(Clock::now() - started) / out.iterations;
  write_point();
  return out;
}

}  // namespace

struct RiccatiSolver::State {
  Chain<3> at_once;
  Chain<5> lagging;
};

RiccatiSolver::RiccatiSolver() : state_{std::make_unique<State>()} {}
RiccatiSolver::~RiccatiSolver() = default;
RiccatiSolver::RiccatiSolver(RiccatiSolver&&) noexcept = default;
RiccatiSolver& RiccatiSolver::operator=(RiccatiSolver&&) noexcept = default;

const Solution& RiccatiSolver::solve(const Ocp& ocp, const Iterate& guess,
                                     const SolveLimits& limits) {
  if (ocp.lag.any()) return state_->lagging.solve(ocp, guess, limits);
  return state_->at_once.solve(ocp, guess, limits);
}

}  // namespace tandem
