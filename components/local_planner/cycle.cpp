// SPDX-License-Identifier: Apache-2.0
#include "local_planner/cycle.hpp"

#include <algorithm>
#include <cmath>

#include "local_planner/guesses.hpp"
#include "local_planner/guidance.hpp"
#include "local_planner/warm_start.hpp"

namespace tandem {
namespace {

constexpr double kLeftOut = 0.005;   // [m] miss by an unlisted pair that asks for a second solve
constexpr double kTolerated = 0.02;  // [m] of slack in a motion in good order
constexpr double kLeastPull = 50.0;  // [1/m] for the penalty, where the reference hardly pulls

// Limits of a speed at stage k; wider where the command in force lies outside, by what the
// acceleration cannot take back until then. The 0.9 leaves the programme an interior.
Interval reachable(double min, double max, double command, double step) {
  return {std::min(min, command + 0.9 * step), std::max(max, command - 0.9 * step)};
}

// Largest |x|, |y| on the way to rest, after one step in which the command hardly changes.
double extent_of_braking(const Cycle& cycle) {
  Start after = cycle.start;
  after.X_MB = integrate(after.X_MB, after.command, cycle.params.dt);
  const Motion motion = braking(after, cycle.params.dt, cycle.robot.a_max, cycle.robot.alpha_max);
  double extent = std::max(std::abs(cycle.start.X_MB.x), std::abs(cycle.start.X_MB.y));
  for (const Pose2& X : to_plan(motion, 0.0).X_MB)
    extent = std::max({extent, std::abs(X.x), std::abs(X.y)});
  return extent + 0.01;
}

}  // namespace

Body body_of(const NmpcParams& params, const RobotParams& robot) {
  Body body{footprint_of(robot), {}, params.disc_radius > 0.0};
  body.discs = body.round ? std::vector<Disc>{{{0.0, 0.0}, params.disc_radius}}
                          : cover_by_discs(body.footprint, params.discs);
  return body;
}

bool is_valid(const PlanRequest& request) {
  const bool target =
      request.method == Method::kIntention ? is_finite(request.user) : is_finite(request.X_MG);
  const auto is_shape = [](const Obstacle& o) {
    return o.p_MO.allFinite() && o.v_MO.allFinite() && std::isfinite(o.a) && std::isfinite(o.b) &&
           std::isfinite(o.angle) && o.a > 0.0 && o.b > 0.0;
  };
  return target && std::isfinite(request.t) && is_finite(request.X_MB) &&
         is_finite(request.command) && is_finite(request.measured) &&
         std::all_of(request.obstacles.begin(), request.obstacles.end(), is_shape);
}

Cycle begin_cycle(const PlanRequest& request, const NmpcParams& params, const RobotParams& robot,
                  const Body& body) {
  // Delay compensation: meanwhile from the measured twist to the command in force.
  const Twist2 mean{0.5 * (request.measured.v + request.command.v),
                    0.5 * (request.measured.w + request.command.w)};
  const Start start{integrate(request.X_MB, mean, params.delay), request.command,
                    request.t + params.delay};
  Cycle cycle{.params = params,
              .robot = robot,
              .body = body,
              .request = request,
              .start = start,
              .wish = forecast(request, start.X_MB, params, robot),
              .costs = {},
              .to_avoid = {},
              .limits = {.margin = params.margin,
                         .start = params.delay,
                         .dt = params.dt,
                         .max_pairs = params.max_pairs},
              .least_slack = 0.0};
  cycle.costs = stage_costs(request, cycle.wish, params, robot);
  for (StageCost& cost : cycle.costs) cost.X_MR = guided(cost.X_MR, request.guidance);
  cycle.to_avoid = passable(body, {.X_MB = start.X_MB, .start = params.delay}, request.obstacles);
  PairLimits here = cycle.limits;
  here.dt = 0.0;
  const auto gap = clearances(body, request.obstacles, std::span(&start.X_MB, 1), here);
  cycle.least_slack = std::max(0.0, -gap.front());
  return cycle;
}

Ocp problem(const Cycle& cycle, const Forecast& guess) {
  Ocp ocp{
      .dt = cycle.params.dt,
      .half = cycle.params.model == "arc" ? 0.5 * cycle.params.dt : 0.0,
      .slack_weight = cycle.params.weight_slack *
                      std::max(kLeastPull, pull(cycle.costs, cycle.start.X_MB, cycle.params.dt)),
      .gap_v = cycle.params.margin_v,
      .gap_w = cycle.params.margin_w,
      .X_MB = cycle.start.X_MB,
      .command = cycle.start.command};
  const Twist2& u = cycle.start.command;
  double time = cycle.params.control_period;
  for (int k = 0; k < cycle.params.horizon_steps; ++k, time += cycle.params.dt) {
    const double step = k == 0 ? cycle.params.control_period : cycle.params.dt;
    ocp.v.push_back(reachable(cycle.robot.v_min, cycle.robot.v_max, u.v, cycle.robot.a_max * time));
    ocp.w.push_back(
        reachable(-cycle.robot.w_max, cycle.robot.w_max, u.w, cycle.robot.alpha_max * time));
    ocp.change_v.push_back({-cycle.robot.a_max * step, cycle.robot.a_max * step});
    ocp.change_w.push_back({-cycle.robot.alpha_max * step, cycle.robot.alpha_max * step});
  }
  if (cycle.params.workspace > 0.0)
    ocp.workspace = std::max(cycle.params.workspace, extent_of_braking(cycle));
  auto pairs = nearest_pairs(cycle.body, cycle.request.obstacles, std::span(guess.X_MB).subspan(1),
                             cycle.limits);
  for (std::size_t k = 0; k < cycle.costs.size(); ++k)
    ocp.stages.push_back({cycle.costs[k], std::move(pairs[k])});
  return ocp;
}

Candidate rate(const Cycle& cycle, Ocp ocp, const Forecast& motion) {
  Candidate out{.ocp = std::move(ocp), .motion = {{}, {cycle.start.X_MB}}};
  Twist2 u = cycle.start.command;
  for (std::size_t k = 0; k < motion.twist.size(); ++k) {
    const Interval &dv = out.ocp.change_v[k], &dw = out.ocp.change_w[k];
    const Twist2& wanted = motion.twist[k];
    u = {u.v + std::clamp(std::clamp(wanted.v, out.ocp.v[k].min, out.ocp.v[k].max) - u.v, dv.min,
                          dv.max),
         u.w + std::clamp(std::clamp(wanted.w, out.ocp.w[k].min, out.ocp.w[k].max) - u.w, dw.min,
                          dw.max)};
    out.motion.twist.push_back(u);
    out.motion.X_MB.push_back(advance(out.ocp, out.motion.X_MB.back(), u));
  }
  Iterate point = cold_start(out.ocp, out.motion);
  const auto gaps = clearances(cycle.body, cycle.request.obstacles,
                               std::span(out.motion.X_MB).subspan(1), cycle.limits);
  for (std::size_t k = 0; k < gaps.size(); ++k) {
    const double missed = growth(out.ocp, out.motion.twist[k]) - gaps[k];
    point.z[kBlock * k + kSlack] = std::max(0.0, missed);
    out.slack = std::max(out.slack, missed);
  }
  out.clearance = *std::min_element(gaps.begin(), gaps.end()) + cycle.params.margin;
  out.cost = cost(out.ocp, point.z);
  const double matters = cycle.params.control_period + cycle.params.dt +
                         stopping_time(out.motion.twist.front(), cycle.robot);
  out.clear = is_clear(cycle.body,
                       {cycle.start.X_MB, cycle.params.delay, cycle.params.dt, out.motion.twist},
                       cycle.to_avoid, matters);
  return out;
}

bool left_out_a_pair(const Cycle& cycle, const Candidate& candidate) {
  const auto gaps = clearances(cycle.body, cycle.request.obstacles,
                               std::span(candidate.motion.X_MB).subspan(1), cycle.limits);
  for (std::size_t k = 0; k < gaps.size(); ++k)
    if (gaps[k] < -candidate.solution.point.z[kBlock * k + kSlack] - kLeftOut) return true;
  return false;
}

bool is_poor(const Cycle& cycle, const Candidate& candidate) {
  const bool tunnels = candidate.slack > cycle.least_slack + kTolerated;
  const bool is_near = candidate.clearance < cycle.limits.reach;
  if (!candidate.clear || tunnels) return true;
  return is_near && is_stuck(cycle.request, cycle.wish, candidate.motion,
                             cycle.params.dt * cycle.params.horizon_steps, cycle.robot);
}

Forecast cold_guess(const Cycle& cycle) {
  return stopped_in_time(cycle.wish, cycle.body, cycle.request.obstacles, cycle.limits,
                         cycle.robot);
}

std::vector<Forecast> other_guesses(const Cycle& cycle) {
  const auto stopped = [&](const Forecast& motion) {
    return stopped_in_time(motion, cycle.body, cycle.request.obstacles, cycle.limits, cycle.robot);
  };
  std::vector<Forecast> guesses;
  for (const auto& p_MV :
       points_beside(cycle.wish, cycle.body, cycle.request.obstacles, cycle.limits))
    guesses.push_back(
        stopped(forecast_via(p_MV, cycle.request, cycle.start.X_MB, cycle.params, cycle.robot)));
  guesses.push_back(stopped(cycle.wish));
  return guesses;
}

}  // namespace tandem
