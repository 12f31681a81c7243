// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/nmpc.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tandem/local_planner/candidate_search.hpp"
#include "tandem/local_planner/close_approach.hpp"
#include "tandem/local_planner/cycle.hpp"
#include "tandem/local_planner/deadlock.hpp"
#include "tandem/local_planner/delay_estimator.hpp"
#include "tandem/local_planner/standing_people.hpp"
#include "tandem/local_planner/trail.hpp"
#include "tandem/model/brief_push.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

using Clock = CandidateSearch::Clock;

constexpr double kLeads = 2.0;  // [s] ahead of the robot: assumed leader in close approach

}  // namespace

struct Nmpc::State {
  NmpcParams params;
  RobotParams robot;
  Body body;
  CandidateSearch search;
  Plan good = {};  // last plan with source kSolution
  DelayEstimator loop{robot};
  std::vector<Sent> sent = {};  // during the last `delay` seconds
  Trail trail = {};             // of the leader
  Deadlock deadlock = {};
  CloseApproach approach = {};
  BriefPush stick = {};

  void measure_delay(const PlanRequest& request);
  void note_command(const PlanRequest& request);
  Plan finish(const Cycle& cycle, const Candidate& best);
  Plan fall_back(const Cycle& cycle, PlanStatus status) const;
  Plan yield(const Twist2& user, const Cycle& cycle, Plan plan) const;
  Plan rest(const PlanRequest& request);
  Plan plan_for(const PlanRequest& request, Clock::time_point started);
  Plan refuse(const PlanRequest& bad);
};

void Nmpc::State::measure_delay(const PlanRequest& request) {
  loop.on_command(request.command, sent.empty() ? request.t : sent.back().until);
  loop.on_measurement(request.measured, request.t);
  const double modelled = 0.5 * (params.lag_v + params.lag_w);
  if (const auto measured = loop.delay()) params.delay = std::max(0.0, *measured - modelled);
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

Plan Nmpc::State::finish(const Cycle& cycle, const Candidate& best) {
  const SolveStatus status = best.solution.status;
  const bool usable = search.is_usable(cycle, best);
  search.remember(cycle, best);
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
  (void)deadlock.holds(false, request.measured, request.t);
  approach = {};
  return resting(request, params.delay, params.control_period, robot);
}

Plan Nmpc::State::plan_for(const PlanRequest& request, Clock::time_point started) {
  note_command(request);
  PlanRequest able = request;
  able.user = limit(request.user, robot);
  const bool led = request.method == Method::kLeader ||
                   (request.method == Method::kPath && request.path.empty());
  // During a close approach the leader waits beside the robot, so a plan for it would always stand.
  // Plan for a leader ahead instead, to find out whether plans make progress again.
  if (led && approach.is_near()) {
    able.method = Method::kLeader;
    able.X_MG = integrate(request.X_MB, able.user, kLeads);
    trail.clear();
  }
  std::vector<Eigen::Vector2d> way;
  if (able.method == Method::kPath && !request.path.empty()) {
    trail.clear();
    way = free_points(request.path, body, request.obstacles, {.margin = params.margin});
    able.trail = way;
  } else if (able.method == Method::kPath) {
    trail.extend(request.X_MG.position(), request.X_MB.position());
    way = trail.free_points(body, request.obstacles, {.margin = params.margin},
                            leader_onward(able, params));
    able.trail = way;
  }
  const std::vector<Obstacle> obstacles = obstacles_of_the_plan(able, body, params, robot);
  able.obstacles = obstacles;
  const Cycle cycle = begin_cycle(able, params, robot, body, sent);
  Plan plan = finish(cycle, search.find(cycle, started));
  const bool steered = request.method != Method::kGoal && request.user != Twist2{};
  const auto nearer = approach.instead_of(plan, cycle);
  if (deadlock.holds(request.refused, request.measured, request.t) && steered)
    plan = yield(able.user, cycle, std::move(plan));
  else if (nearer)
    plan = yield(*nearer, cycle, std::move(plan));
  const SearchEffort& effort = search.effort();
  plan.iterations = effort.iterations;
  plan.guesses = effort.guesses;
  plan.solves = effort.solves;
  plan.confirmed = effort.confirmed;
  plan.disagreements = effort.disagreements;
  return plan;
}

// A request with a non-finite value is not trusted: brake from the command if that one is finite.
Plan Nmpc::State::refuse(const PlanRequest& bad) {
  search.forget();
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
  state_ = std::make_unique<State>(
      State{params, robot, body_of(params, robot), CandidateSearch{solver_named(params.solver)}});
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
  const auto started = Clock::now();
  const bool rests = state.stick.rests(request.rests, request.t) && request.method != Method::kGoal;
  Plan plan = !is_valid(request) ? state.refuse(request)
              : rests            ? state.rest(request)
                                 : state.plan_for(request, started);
  plan.solve_time = std::chrono::duration<double>(Clock::now() - started).count();
  return plan;
}

void Nmpc::reset() {
  state_->loop.forget();
  state_->search.reset();
  state_->good = {};
  state_->sent.clear();
  state_->trail.clear();
  state_->deadlock = {};
  state_->approach = {};
}

}  // namespace tandem
