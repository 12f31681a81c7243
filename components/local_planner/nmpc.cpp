// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/nmpc.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "tandem/local_planner/close_approach.hpp"
#include "tandem/local_planner/cycle.hpp"
#include "tandem/local_planner/deadlock.hpp"
#include "tandem/local_planner/delay_estimator.hpp"
#include "tandem/local_planner/solvers/solver.hpp"
#include "tandem/local_planner/trail.hpp"
#include "tandem/local_planner/warm_start.hpp"
#include "tandem/model/brief_push.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLongestReuse = 1.0;  // [s] age up to which a plan is a warm start or a fallback
constexpr double kSurprise = 0.3;      // [m], [rad] deviation that makes the last solution useless
constexpr double kReserve = 0.003;     // [s] of the budget for the check and the fallback
constexpr double kExplores = 0.3;      // share of the budget within which other guesses may start
constexpr double kLeads = 2.0;         // [s] ahead of the robot: assumed leader in close approach
// A motion from another guess replaces the last plan if its value is below this share of the last
// plan's; the second factor holds if the last plan is poor.
constexpr double kBetter = 0.9;
constexpr double kBetterThanPoor = 0.98;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

struct Nmpc::State {
  NmpcParams params;
  RobotParams robot;
  Body body;
  Solver explorer;                  // solves from every guess
  std::optional<Solver> verifier;   // verifies the best solution; only with solver "certified"
  std::optional<Solved> last = {};  // warm start
  Plan good = {};                   // last plan with source kSolution
  DelayEstimator loop{robot};
  std::vector<Sent> sent = {};  // during the last `delay` seconds
  Trail trail = {};             // of the leader
  Deadlock stalemate = {};
  CloseApproach approach = {};
  BriefPush stick = {};
  double iteration_time = 0.0;  // smoothed [s]
  double solve_time = 0.0;      // of one solve, smoothed [s]
  int timeouts = 0;             // consecutive
  unsigned turn = 0;            // index of the next constant twist to start from

  // State of the current cycle.
  Clock::time_point started = {};
  int iterations = 0, guesses = 0, solves = 0, confirmed = 0, disagreements = 0;
  int effort = 0;  // iterations, as counted against iteration_budget

  void measure_delay(const PlanRequest& request);
  void note_command(const PlanRequest& request);
  double elapsed(const Cycle& cycle) const { return cycle.start.t0 - last->t0; }
  bool is_continued(const Cycle& cycle) const;
  bool has_time_for_another(double share) const;
  SolveLimits solve_limits() const;

  Candidate first_candidate(const Cycle& cycle);
  Candidate attempt(const Cycle& cycle, const Forecast& guess, bool warm);
  Candidate solve(Solver& solver, const Cycle& cycle, Ocp ocp, const Iterate& guess);
  void explore(const Cycle& cycle, Candidate& best);
  void certify(const Cycle& cycle, Candidate& best);

  void remember(const Cycle& cycle, const Candidate& best);
  bool is_usable(const Cycle& cycle, const Candidate& best) const;
  Plan finish(const Cycle& cycle, const Candidate& best);
  Plan fall_back(const Cycle& cycle, PlanStatus status) const;
  Plan yield(const Twist2& user, const Cycle& cycle, Plan plan) const;
  Plan rest(const PlanRequest& request);
  Plan plan_for(const PlanRequest& request);
  Plan refuse(const PlanRequest& bad);
};

void Nmpc::State::measure_delay(const PlanRequest& request) {
  loop.on_command(request.command, sent.empty() ? request.t : sent.back().until);
  loop.on_measurement(request.measured, request.t);
  const double told = 0.5 * (params.lag_v + params.lag_w);
  if (const auto measured = loop.delay()) params.delay = std::max(0.0, *measured - told);
}

// The request's command has been in force since the previous request.
void Nmpc::State::note_command(const PlanRequest& request) {
  if (params.measure_delay) measure_delay(request);
  const double before = sent.empty() ? request.t : sent.back().until;
  const bool follows = request.t > before && request.t - before < kLongestReuse;
  if (!follows) sent.clear();
  sent.push_back({request.command, follows ? before : request.t, request.t});
  std::erase_if(sent, [&](const Sent& s) { return s.until < request.t - params.delay; });
}

// Whether the last solution is recent and the robot is where it predicted.
bool Nmpc::State::is_continued(const Cycle& cycle) const {
  if (!(elapsed(cycle) >= 0.0 && elapsed(cycle) < kLongestReuse)) return false;
  const Pose2 expected = shifted_start(*last, elapsed(cycle));
  return (expected.position() - cycle.start.X_MB.position()).norm() < kSurprise &&
         std::abs(wrap_angle(expected.theta - cycle.start.X_MB.theta)) < kSurprise;
}

SolveLimits Nmpc::State::solve_limits() const {
  SolveLimits limits{.iteration_time = iteration_time, .iterations = params.max_iterations};
  if (params.iteration_budget > 0)
    limits.iterations = std::clamp(params.iteration_budget - effort, 1, params.max_iterations);
  if (params.time_budget > 0.0)
    limits.deadline = started + std::chrono::duration_cast<Clock::duration>(
                                    std::chrono::duration<double>(params.time_budget - kReserve));
  return limits;
}

// Whether another solve is expected to finish within that share of the budget.
bool Nmpc::State::has_time_for_another(double share) const {
  if (params.iteration_budget > 0 && effort >= share * params.iteration_budget) return false;
  if (params.time_budget <= 0.0) return true;
  return seconds_since(started) + 1.2 * solve_time < share * (params.time_budget - kReserve);
}

Candidate Nmpc::State::solve(Solver& solver, const Cycle& cycle, Ocp ocp, const Iterate& guess) {
  const auto before = Clock::now();
  Answer answer = solver.solve(ocp, guess, solve_limits());
  Solution& solution = answer.solution;
  ++solves;
  iterations += solution.iterations;
  effort += answer.effort;
  confirmed += answer.verdict == Verdict::kConfirmed ? 1 : 0;
  disagreements += answer.verdict == Verdict::kDisagreement ? 1 : 0;
  // Smoothed and bounded, so that one preempted iteration cannot keep later solves from starting.
  // A solve that had no time for an iteration lets the estimate decay.
  iteration_time =
      std::min(0.7 * iteration_time + 0.3 * solution.iteration_time, 0.1 * params.time_budget);
  const double took = seconds_since(before);
  solve_time = solve_time > 0.0 ? 0.8 * solve_time + 0.2 * took : took;
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
Candidate Nmpc::State::attempt(const Cycle& cycle, const Forecast& guess, bool warm) {
  Ocp ocp = problem(cycle, guess);
  const Iterate point =
      warm ? warm_start(*last, elapsed(cycle), ocp) : cold_start(ocp, within_limits(ocp, guess));
  Candidate out = solve(explorer, cycle, std::move(ocp), point);
  if (out.solution.status == SolveStatus::kFailed || !left_out_a_pair(out) ||
      !has_time_for_another(1.0))
    return out;
  ocp = problem(cycle, out.motion);
  const Solved so_far{out.ocp, out.solution.point, cycle.start.t0};
  return solve(explorer, cycle, ocp, warm_start(so_far, 0.0, ocp));
}

Candidate Nmpc::State::first_candidate(const Cycle& cycle) {
  ++guesses;
  if (!last) return attempt(cycle, cold_guess(cycle), false);
  const Ocp ocp = problem(cycle, cycle.nominal);
  Candidate out = attempt(cycle, shifted_motion(*last, elapsed(cycle), ocp), true);
  const bool failed = out.solution.status == SolveStatus::kFailed ||
                      out.solution.status == SolveStatus::kTimeout || !is_clear(cycle, out);
  if (!failed || !has_time_for_another(1.0)) return out;
  ++guesses;
  Candidate cold = attempt(cycle, cold_guess(cycle), false);
  const bool wins = is_clear(cycle, cold) && (!is_clear(cycle, out) || cold.value < out.value);
  return wins ? cold : out;
}

// Solves from other guesses while time permits. The last plan is replaced only by a clearly better
// motion, so that the robot does not alternate between two ways of nearly equal value.
void Nmpc::State::explore(const Cycle& cycle, Candidate& best) {
  if (params.extra_guesses == 0) return;
  const bool usable = best.solution.status != SolveStatus::kFailed && is_clear(cycle, best);
  const bool poor = !usable || is_poor(cycle, best);
  const double to_beat = usable ? (poor ? kBetterThanPoor : kBetter) * best.value : kUnbounded;
  const unsigned arcs = static_cast<unsigned>(params.extra_guesses) * (poor ? 3 : 1);
  std::optional<Candidate> found;
  std::vector<Forecast> others = other_guesses(cycle, turn, arcs);
  guesses += static_cast<int>(others.size());
  for (const Forecast& guess : most_promising_first(cycle, std::move(others))) {
    if (!has_time_for_another(kExplores)) break;
    Candidate other = attempt(cycle, guess, false);
    const bool wins = other.solution.status != SolveStatus::kFailed &&
                      other.value < (found ? found->value : to_beat);
    if (wins && is_clear(cycle, other)) found = std::move(other);
  }
  turn += arcs;
  if (found) best = std::move(*found);
}

// Solves again from the best solution with the verifier, which compares both solvers' results.
void Nmpc::State::certify(const Cycle& cycle, Candidate& best) {
  if (!verifier) return;
  Candidate verified = solve(*verifier, cycle, best.ocp, best.solution.point);
  best.verdict = verified.verdict;
  if (is_clear(cycle, verified) || !is_clear(cycle, best)) best = std::move(verified);
}

// Keeps the point for the next warm start, unless the solve failed or three in a row timed out.
void Nmpc::State::remember(const Cycle& cycle, const Candidate& best) {
  const SolveStatus status = best.solution.status;
  timeouts = status == SolveStatus::kTimeout ? timeouts + 1 : 0;
  if (status != SolveStatus::kFailed && timeouts < 3)
    last = Solved{best.ocp, best.solution.point, cycle.start.t0};
  else
    last.reset();
}

// A solution cut short by the time limit must not cost more than the last solution, shifted.
bool Nmpc::State::is_usable(const Cycle& cycle, const Candidate& best) const {
  if (best.solution.status == SolveStatus::kFailed || !is_clear(cycle, best)) return false;
  if (best.solution.status != SolveStatus::kTimeout || !last) return true;
  const Forecast before = shifted_motion(*last, elapsed(cycle), best.ocp);
  return best.cost <= rate(cycle, best.ocp, before).cost;
}

Plan Nmpc::State::finish(const Cycle& cycle, const Candidate& best) {
  const SolveStatus status = best.solution.status;
  const bool usable = is_usable(cycle, best);
  remember(cycle, best);
  if (!usable)
    return fall_back(
        cycle, status == SolveStatus::kTimeout ? PlanStatus::kTimeout : PlanStatus::kInfeasible);
  good = {
      .status = status == SolveStatus::kConverged ? PlanStatus::kOptimal : PlanStatus::kAcceptable,
      .source = PlanSource::kSolution,
      .solver = best.solver,
      .verdict = best.verdict,
      .command = best.motion.twist.front(),
      .t0 = cycle.start.t0,
      .dt = params.dt,
      .X_MB = best.motion.X_MB,
      .twist = best.motion.twist,
      .cost = best.cost,
      .parts = cost_parts(best),
      .active = active_rows(best),
      .slack = best.slack,
      .clearance = best.clearance};
  return good;
}

// Without a solution, the first of these that is clear of obstacles: the rest of the last good
// plan, braking at a_max, braking at the hardware limit (unchecked). At rest, braking means
// standing.
Plan Nmpc::State::fall_back(const Cycle& cycle, PlanStatus status) const {
  const Start& start = cycle.start;
  const double period = params.control_period;
  const MotorLag lag = lag_of(params);
  PlanSource source = PlanSource::kPrevious;
  Motion motion;
  bool found = false;
  if (!good.twist.empty() && start.t0 >= good.t0 && start.t0 - good.t0 < kLongestReuse) {
    motion = with_lag(rest_of(good, start, period, robot), lag, start.moves);
    motion.start = params.delay;
    found = is_clear(body, motion, cycle.to_avoid,
                     2.0 * period + stopping_time(start.command, robot) + coasting_time(lag));
  }
  if (!found) {
    source = PlanSource::kBraking;
    motion = with_lag(braking(start, period, robot.a_max, robot.alpha_max), lag, start.moves);
    motion.start = params.delay;
    if (!is_clear(body, motion, cycle.to_avoid, 1e9))
      motion = with_lag(braking(start, period, std::max(robot.a_max, robot.a_brake),
                                std::max(robot.alpha_max, robot.alpha_brake)),
                        lag, start.moves);
  }
  Plan plan = to_plan(motion, start.t0);
  plan.status = status;
  plan.source =
      start.command == Twist2{} && source == PlanSource::kBraking ? PlanSource::kStanding : source;
  return plan;
}

// Replaces the plan's motion by the person's twist, within the acceleration limits.
Plan Nmpc::State::yield(const Twist2& user, const Cycle& cycle, Plan plan) const {
  const Forecast nominal =
      forecast_of(user, cycle.request, {cycle.start.X_MB, cycle.start.moves}, params, robot);
  plan.source = PlanSource::kYielded;
  plan.command = nominal.twist.front();
  plan.X_MB = nominal.X_MB;
  plan.twist = nominal.twist;
  return plan;
}

Plan Nmpc::State::rest(const PlanRequest& request) {
  note_command(request);
  trail.clear();
  (void)stalemate.holds(false, request.measured, request.t);
  approach = {};
  return resting(request, params.delay, params.control_period, robot);
}

Plan Nmpc::State::plan_for(const PlanRequest& request) {
  note_command(request);
  PlanRequest able = request;
  able.user = limit(request.user, robot);
  const bool led = request.method == Method::kLeader || request.method == Method::kPath;
  // During a close approach the leader waits beside the robot, so a plan for it would always stand.
  // Plan for a leader ahead instead, to find out whether plans make progress again.
  if (led && approach.is_near()) {
    able.method = Method::kLeader;
    able.X_MG = integrate(request.X_MB, able.user, kLeads);
    trail.clear();
  }
  std::vector<Eigen::Vector2d> way;
  if (able.method == Method::kPath) {
    trail.extend(request.X_MG.position(), request.X_MB.position());
    way = trail.free_points(body, request.obstacles, {.margin = params.margin},
                            leader_onward(able, params));
    able.trail = way;
  }
  const Cycle cycle = begin_cycle(able, params, robot, body, sent);
  iterations = guesses = solves = effort = 0;
  confirmed = disagreements = 0;
  if (last && !is_continued(cycle)) last.reset();
  Candidate best = first_candidate(cycle);
  explore(cycle, best);
  certify(cycle, best);
  Plan plan = finish(cycle, best);
  const bool steered = request.method != Method::kGoal && request.user != Twist2{};
  const auto nearer = approach.instead_of(plan, cycle);
  if (stalemate.holds(request.refused, request.measured, request.t) && steered)
    plan = yield(able.user, cycle, std::move(plan));
  else if (nearer)
    plan = yield(*nearer, cycle, std::move(plan));
  plan.iterations = iterations;
  plan.guesses = guesses;
  plan.solves = solves;
  plan.confirmed = confirmed;
  plan.disagreements = disagreements;
  return plan;
}

// A request with a non-finite value is not trusted: brake from the command if that one is finite.
Plan Nmpc::State::refuse(const PlanRequest& bad) {
  last.reset();
  good = {};
  sent.clear();
  trail.clear();
  const Twist2 command = is_finite(bad.command) ? bad.command : Twist2{};
  const Pose2 X_MB = is_finite(bad.X_MB) ? bad.X_MB : Pose2{};
  const double t = std::isfinite(bad.t) ? bad.t : 0.0;
  Plan plan = to_plan(braking({X_MB, command, t + params.delay}, params.control_period, robot.a_max,
                              robot.alpha_max),
                      t + params.delay);
  plan.source = command == Twist2{} ? PlanSource::kStanding : PlanSource::kBraking;
  return plan;
}

Nmpc::Nmpc(const NmpcParams& params, const RobotParams& robot) {
  check(params);
  check(robot);
  if (params.control_period > params.dt)
    throw std::invalid_argument("control_period must not exceed dt");
  if (params.time_budget > 0.0 && params.time_budget <= 2.0 * kReserve)
    throw std::invalid_argument("time_budget must be 0 (unlimited) or above 0.006 s");
  const SolverKind kind = solver_named(params.solver);
  const bool certified = kind == SolverKind::kCertified;
  state_ = std::make_unique<State>(State{params, robot, body_of(params, robot),
                                         Solver{certified ? SolverKind::kStructured : kind},
                                         certified ? std::optional{Solver{kind}} : std::nullopt});
}

Nmpc::~Nmpc() = default;
Nmpc::Nmpc(Nmpc&&) noexcept = default;
Nmpc& Nmpc::operator=(Nmpc&&) noexcept = default;

void Nmpc::set_params(const NmpcParams& params) {
  Nmpc next{params, state_->robot};
  next.state_->good = std::move(state_->good);
  next.state_->loop = std::move(state_->loop);
  next.state_->sent = std::move(state_->sent);
  next.state_->trail = std::move(state_->trail);
  *this = std::move(next);
}

Plan Nmpc::solve(const PlanRequest& request) {
  State& state = *state_;
  state.started = Clock::now();
  const bool rests = state.stick.rests(request.rests, request.t) && request.method != Method::kGoal;
  Plan plan = !is_valid(request) ? state.refuse(request)
              : rests            ? state.rest(request)
                                 : state.plan_for(request);
  plan.solve_time = seconds_since(state.started);
  return plan;
}

void Nmpc::reset() {
  state_->loop.forget();
  state_->last.reset();
  state_->good = {};
  state_->sent.clear();
  state_->trail.clear();
  state_->stalemate = {};
  state_->approach = {};
  state_->timeouts = 0;
  state_->turn = 0;
}

}  // namespace tandem
