// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/cycle.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tandem/local_planner/guesses.hpp"
#include "tandem/local_planner/guidance.hpp"
#include "tandem/local_planner/ocp/stage_terms.hpp"
#include "tandem/local_planner/warm_start.hpp"

namespace tandem {
namespace {

constexpr double kLeftOut = 0.005;    // [m] violation by a left-out pair that needs a second solve
constexpr double kTolerated = 0.02;   // [m] slack beyond the start's that is still acceptable
constexpr double kActive = 1e-3;      // [m] a row with a smaller residual counts as active
constexpr double kLeastPull = 50.0;   // [1/m] lower bound of the pull that scales the penalty
constexpr double kSlackWeight = 3.0;  // penalty per metre of slack, in units of that pull
constexpr double kAfterwards = 8.0;   // stages beyond the horizon, charged at the final pose

// Limits of a speed at one stage. If the command in force lies outside, they are widened to what is
// reachable by then; `step` is the largest change. The factor 0.9 leaves a nonempty interior.
Interval reachable(double min, double max, double command, double step) {
  return {std::min(min, command + 0.9 * step), std::max(max, command - 0.9 * step)};
}

// Largest change of speed toward rest over `step` [s], beginning `from` [s] after the start: at
// the braking limit while the command in force is not braked to zero, then at a_max.
double fall(const Cycle& cycle, double from, double step) {
  const double braking = braking_of(cycle.request, cycle.robot);
  const double fast = std::clamp(std::abs(cycle.start.command.v) / braking - from, 0.0, step);
  return braking * fast + cycle.robot.a_max * (step - fast);
}

// Largest |x|, |y| on the way to rest, if the command is held for one step first.
double extent_of_braking(const Cycle& cycle) {
  const MotorLag lag = lag_of(cycle.params);
  const Moving moving =
      follow({cycle.start.X_MB, cycle.start.moves}, cycle.start.command, lag, cycle.params.dt);
  Start after = cycle.start;
  after.X_MB = moving.X_MB;
  const Motion motion = with_lag(
      braking(after, cycle.params.dt, cycle.robot.a_max, cycle.robot.alpha_max), lag, moving.twist);
  double extent = std::max(std::abs(cycle.start.X_MB.x), std::abs(cycle.start.X_MB.y));
  for (const Pose2& X : to_plan(motion, 0.0).X_MB)
    extent = std::max({extent, std::abs(X.x), std::abs(X.y)});
  return extent + 0.01;
}

// Cost of one more stage at rest in the motion's final pose.
double final_cost(const Cycle& cycle, const Forecast& motion) {
  const StageCost& c = cycle.base.stages.back().cost;
  const Pose2& X = motion.X_MB.back();
  const Eigen::Vector2d off = X.position() - c.X_MR.position();
  return off.dot(c.pull(off)) + 2.0 * c.q_theta * (1.0 - std::cos(X.theta - c.X_MR.theta));
}

// Delay compensation: the robot has yet to execute the commands of the last `delay` seconds. For
// the time before the first known command, and without a lag, the mean of the measured twist and
// that command is assumed.
Moving predicted(const PlanRequest& request, double delay, const MotorLag& lag,
                 std::span<const Sent> sent) {
  const Twist2 first = sent.empty() ? request.command : sent.front().twist;
  const Twist2 mean{0.5 * (request.measured.v + first.v), 0.5 * (request.measured.w + first.w)};
  double t = request.t - delay;
  const double known = sent.empty() ? request.t : std::max(t, sent.front().from);
  const Moving measured{request.X_MB, request.measured};
  Moving at = lag.any() ? follow(measured, first, lag, known - t)
                        : Moving{integrate(request.X_MB, mean, known - t), first};
  t = known;
  for (const Sent& s : sent) {
    at = follow(at, s.twist, lag, std::max(0.0, s.until - t));
    t = std::max(t, s.until);
  }
  return at;
}

// The problem without pairs, see problem().
Ocp without_pairs(const Cycle& cycle, std::vector<StageCost> costs) {
  Ocp ocp{.dt = cycle.params.dt,
          .half = cycle.params.model == "arc" ? 0.5 * cycle.params.dt : 0.0,
          .slack_weight =
              kSlackWeight * std::max(kLeastPull, pull(costs, cycle.start.X_MB, cycle.params.dt)),
          .gap_v = cycle.params.margin_v,
          .gap_w = cycle.params.margin_w,
          .X_MB = cycle.start.X_MB,
          .command = cycle.start.command,
          .lag = LagStep::over(cycle.params.dt, lag_of(cycle.params)),
          .motion = cycle.start.moves};
  const Twist2& u = cycle.start.command;
  double time = cycle.params.control_period;
  for (int k = 0; k < cycle.params.horizon_steps; ++k, time += cycle.params.dt) {
    const double step = k == 0 ? cycle.params.control_period : cycle.params.dt;
    ocp.v.push_back(reachable(cycle.robot.v_min, cycle.robot.v_max, u.v, cycle.robot.a_max * time));
    ocp.w.push_back(
        reachable(-cycle.robot.w_max, cycle.robot.w_max, u.w, cycle.robot.alpha_max * time));
    const double rise = cycle.robot.a_max * step, less = fall(cycle, time - step, step);
    ocp.change_v.push_back(u.v > 0.0 ? Interval{-less, rise} : Interval{-rise, less});
    ocp.change_w.push_back({-cycle.robot.alpha_max * step, cycle.robot.alpha_max * step});
  }
  if (cycle.params.workspace > 0.0)
    ocp.workspace = std::max(cycle.params.workspace, extent_of_braking(cycle));
  for (StageCost& cost : costs) ocp.stages.push_back({cost, {}});
  return ocp;
}

}  // namespace

Body body_of(const NmpcParams& params, const RobotParams& robot) {
  Body body{footprint_of(robot), {}, params.disc_radius > 0.0};
  body.discs = body.round ? std::vector<Disc>{{{0.0, 0.0}, params.disc_radius}}
                          : cover_by_discs(body.footprint, params.disc_overhang);
  return body;
}

bool is_valid(const PlanRequest& request) {
  const bool target = (request.method == Method::kIntention || is_finite(request.X_MG)) &&
                      (request.method == Method::kGoal || is_finite(request.user));
  const auto is_shape = [](const Obstacle& o) {
    return o.p_MO.allFinite() && o.v_MO.allFinite() && std::isfinite(o.a) && std::isfinite(o.b) &&
           std::isfinite(o.angle) && o.a > 0.0 && o.b > 0.0;
  };
  const bool path = std::all_of(request.path.begin(), request.path.end(),
                                [](const Eigen::Vector2d& p) { return p.allFinite(); });
  return target && path && std::isfinite(request.t) && is_finite(request.X_MB) &&
         is_finite(request.command) && is_finite(request.measured) &&
         std::all_of(request.obstacles.begin(), request.obstacles.end(), is_shape);
}

Cycle begin_cycle(const PlanRequest& request, const NmpcParams& params, const RobotParams& robot,
                  const Body& body, std::span<const Sent> sent) {
  const Moving from = predicted(request, params.delay, lag_of(params), sent);
  const Start start{from.X_MB, request.command, request.t + params.delay, from.twist};
  Cycle cycle{.params = params,
              .robot = robot,
              .body = body,
              .request = request,
              .start = start,
              .nominal = forecast(request, from, params, robot),
              .base = {},
              .to_avoid = {},
              .limits = {.margin = params.margin,
                         .moving = params.margin_moving,
                         .start = params.delay,
                         .dt = params.dt,
                         .max_pairs = params.max_pairs},
              .least_slack = 0.0};
  std::vector<StageCost> costs = stage_costs(request, cycle.nominal, params, robot);
  for (StageCost& cost : costs) cost.X_MR = guided(cost.X_MR, request.guidance);
  cycle.base = without_pairs(cycle, std::move(costs));
  cycle.to_avoid = passable(body, {.X_MB = start.X_MB, .start = params.delay}, request.obstacles);
  PairLimits here = cycle.limits;
  here.dt = 0.0;
  const auto gap = clearances(body, request.obstacles, std::span(&start.X_MB, 1), here);
  cycle.least_slack = std::max(0.0, -gap.front());
  return cycle;
}

Ocp problem(const Cycle& cycle, const Forecast& guess) {
  Ocp ocp = cycle.base;
  auto pairs = nearest_pairs(cycle.body, cycle.request.obstacles, std::span(guess.X_MB).subspan(1),
                             cycle.limits);
  for (std::size_t k = 0; k < ocp.stages.size(); ++k) ocp.stages[k].pairs = std::move(pairs[k]);
  return ocp;
}

Forecast within_limits(const Ocp& ocp, const Forecast& motion) {
  Forecast out{{}, {ocp.X_MB}};
  Moving at{ocp.X_MB, ocp.motion};
  Twist2 u = ocp.command;
  for (std::size_t k = 0; k < motion.twist.size(); ++k) {
    const Interval &dv = ocp.change_v[k], &dw = ocp.change_w[k];
    const Twist2& wanted = motion.twist[k];
    u = {u.v + std::clamp(std::clamp(wanted.v, ocp.v[k].min, ocp.v[k].max) - u.v, dv.min, dv.max),
         u.w + std::clamp(std::clamp(wanted.w, ocp.w[k].min, ocp.w[k].max) - u.w, dw.min, dw.max)};
    out.twist.push_back(u);
    at = advance(ocp, at, u);
    out.X_MB.push_back(at.X_MB);
  }
  return out;
}

Candidate rate(const Cycle& cycle, Ocp ocp, const Forecast& motion) {
  Candidate out{.ocp = std::move(ocp)};
  out.motion = within_limits(out.ocp, motion);
  Iterate point = trajectory(out.ocp, out.motion);
  out.gaps = clearances(cycle.body, cycle.request.obstacles, std::span(out.motion.X_MB).subspan(1),
                        cycle.limits);
  for (std::size_t k = 0; k < out.gaps.size(); ++k) {
    const double missed = speed_margin(out.ocp, out.motion.twist[k]) - out.gaps[k];
    point.z[block(out.ocp) * k + kSlack] = std::max(0.0, missed);
    out.slack = std::max(out.slack, missed);
  }
  out.clearance = *std::min_element(out.gaps.begin(), out.gaps.end()) + cycle.params.margin;
  out.cost = cost(out.ocp, point.z);
  out.value = out.cost + kAfterwards * final_cost(cycle, out.motion);
  return out;
}

bool is_clear(const Cycle& cycle, const Candidate& candidate) {
  const auto& twist = candidate.motion.twist;
  const MotorLag lag = lag_of(cycle.params);
  const double matters = cycle.params.control_period + cycle.params.dt +
                         stopping_time(twist.front(), cycle.robot) + coasting_time(lag);
  const Motion motion{cycle.start.X_MB, cycle.params.delay, cycle.params.dt, twist, lag,
                      cycle.start.moves};
  return is_clear(cycle.body, motion, cycle.to_avoid, matters);
}

CostParts cost_parts(const Candidate& candidate) {
  CostParts parts;
  const Forecast& motion = candidate.motion;
  Twist2 before = candidate.ocp.command;
  for (std::size_t k = 0; k < motion.twist.size(); ++k) {
    const Twist2& u = motion.twist[k];
    const Twist2 change{u.v - before.v, u.w - before.w};
    before = u;
    StageCost pose = candidate.ocp.stages[k].cost, twist = pose, smooth = pose;
    for (StageCost* without : {&twist, &smooth})
      without->q_x = without->q_y = without->q_xy = without->q_theta = 0.0;
    pose.r_v = pose.r_w = pose.c_dir = smooth.r_v = smooth.r_w = smooth.c_dir = 0.0;
    pose.c_v = pose.c_w = twist.c_v = twist.c_w = 0.0;
    const Pose2& X = motion.X_MB[k + 1];
    const Eigen::Vector2d p_MB = X.position();
    const Heading error = Heading::of(X.theta - pose.X_MR.theta);
    parts.pose += cost_terms(pose, u, change, p_MB, error).value;
    parts.twist += cost_terms(twist, u, change, p_MB, error).value;
    parts.change += cost_terms(smooth, u, change, p_MB, error).value;
  }
  parts.slack = candidate.cost - parts.pose - parts.twist - parts.change;
  return parts;
}

int active_rows(const Candidate& candidate) {
  int active = 0;
  const Forecast& motion = candidate.motion;
  for (std::size_t k = 0; k < motion.twist.size(); ++k)
    for (const Pair& pair : candidate.ocp.stages[k].pairs)
      if (clearance(pair, motion.X_MB[k + 1]) - speed_margin(candidate.ocp, motion.twist[k]) <
          kActive)
        ++active;
  return active;
}

bool left_out_a_pair(const Candidate& candidate) {
  for (std::size_t k = 0; k < candidate.gaps.size(); ++k)
    if (candidate.gaps[k] < -at(candidate.ocp, candidate.solution.point.z, k, kSlack) - kLeftOut)
      return true;
  return false;
}

bool is_poor(const Cycle& cycle, const Candidate& candidate) {
  // Such a motion tunnels through an obstacle.
  if (candidate.slack > cycle.least_slack + kTolerated) return true;
  const bool is_near = candidate.clearance < cycle.limits.reach;
  return is_near && is_stuck(cycle.request.method, cycle.nominal,
                             cycle.base.stages.back().cost.X_MR.position(), candidate.motion,
                             cycle.params.dt * cycle.params.horizon_steps, cycle.robot);
}

Forecast cold_guess(const Cycle& cycle) {
  return stopped_in_time(cycle.nominal, cycle.body, cycle.request.obstacles, cycle.limits,
                         cycle.robot);
}

std::vector<Forecast> most_promising_first(const Cycle& cycle, std::vector<Forecast> guesses) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < guesses.size(); ++i)
    order.emplace_back(rate(cycle, cycle.base, guesses[i]).value, i);
  std::sort(order.begin(), order.end());
  std::vector<Forecast> sorted;
  for (const auto& [value, i] : order) sorted.push_back(std::move(guesses[i]));
  return sorted;
}

std::vector<Forecast> other_guesses(const Cycle& cycle, unsigned turn, unsigned arcs) {
  const Moving from{cycle.start.X_MB, cycle.start.moves};
  const RobotParams& robot = cycle.robot;
  const auto toward = [&](double v, double w) {
    return forecast_of({v, w}, cycle.request, from, cycle.params, robot);
  };
  std::vector<Forecast> guesses;
  const auto poses = std::span(cycle.nominal.X_MB).subspan(1);
  const auto& obstacles = cycle.request.obstacles;
  if (first_miss(cycle.body, obstacles, poses, cycle.limits) < poses.size()) {
    for (const auto& p_MV : points_beside(cycle.nominal, cycle.body, obstacles, cycle.limits))
      guesses.push_back(forecast_via(p_MV, cycle.request, from, cycle.params, robot));
    guesses.push_back(toward(0.0, 0.0));
  }
  guesses.push_back(cycle.nominal);
  const double w = 0.6 * robot.w_max;
  const std::array<Twist2, 10> twists{{{robot.v_max, w},
                                       {robot.v_max, -w},
                                       {robot.v_min, 0.0},
                                       {0.0, w},
                                       {0.0, -w},
                                       {0.4 * robot.v_max, w},
                                       {0.4 * robot.v_max, -w},
                                       {robot.v_max, 0.0},
                                       {robot.v_min, w},
                                       {robot.v_min, -w}}};
  for (unsigned i = 0; i < arcs; ++i) {
    const Twist2& twist = twists[(turn + i) % twists.size()];
    guesses.push_back(toward(twist.v, twist.w));
  }
  for (Forecast& guess : guesses)
    guess = stopped_in_time(guess, cycle.body, obstacles, cycle.limits, robot);
  return guesses;
}

}  // namespace tandem
