// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/reference.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tandem/local_planner/trail.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

// Scales (2) and (3), in Krijnen's units, to the magnitude of (1), in Devalla's: one slack weight
// and one barrier parameter must suit all of them.
constexpr double kIntentionScale = 20.0;

// [s] Time constant of the discount on (2) and (3). It moves deviations from the person's command
// to the end of the horizon; without it a robot that is blocked far ahead would never start.
constexpr double kPatience = 2.0;

constexpr double kEases = 0.8;     // a stick below this share of the speed in force asks to brake
constexpr double kEver = 1e9;      // [s]
constexpr double kArrived = 0.15;  // [m] from the target; closer, the forecast turns to its heading
constexpr double kLookahead = 0.4;  // [m] along the trail to the point the forecast steers to
constexpr double kLead = 0.3;       // [m] along the trail from the forecast to the reference

bool is_far_along(const PlanRequest& request) {
  return request.method == Method::kPath && request.trail.size() > 2;
}

using Wanted = std::function<Twist2(const Pose2&)>;

// Follows `wanted` within speed and acceleration limits.
Forecast roll_out(const Wanted& wanted, const PlanRequest& request, const Moving& from,
                  const NmpcParams& params, const RobotParams& robot) {
  Forecast out{{}, {from.X_MB}};
  Moving at = from;
  Twist2 u = request.command;
  const double braking = braking_of(request, robot);
  for (int k = 0; k < params.horizon_steps; ++k) {
    const double period = k == 0 ? params.control_period : params.dt;
    const Twist2 target = limit(wanted(out.X_MB.back()), robot);
    u = {approach(u.v, target.v, robot.a_max, braking, period),
         approach(u.w, target.w, robot.alpha_max * period)};
    out.twist.push_back(u);
    at = follow(at, u, lag_of(params), params.dt);
    out.X_MB.push_back(at.X_MB);
  }
  return out;
}

// Steers to a point, backwards if it lies behind, and slows down to stop there.
Twist2 drive_to(const Eigen::Vector2d& p_MT, const Pose2& X_MB, const RobotParams& robot) {
  const Eigen::Vector2d to = p_MT - X_MB.position();
  const double bearing = wrap_angle(std::atan2(to.y(), to.x()) - X_MB.theta);
  const bool back = std::abs(bearing) > 0.7 * std::numbers::pi && robot.v_min < 0.0;
  const double error = back ? wrap_angle(bearing + std::numbers::pi) : bearing;
  const double fastest = std::sqrt(robot.a_max * to.norm()) * std::max(0.0, std::cos(error));
  const double v = back ? std::max(robot.v_min, -fastest) : std::min(robot.v_max, fastest);
  return {v, std::clamp(1.5 * error, -robot.w_max, robot.w_max)};
}

Wanted wanted_by(const PlanRequest& request, const NmpcParams& params, const RobotParams& robot) {
  if (request.method == Method::kIntention) return [&](const Pose2&) { return request.user; };
  const Pose2 X_MT = leader_after(kEver, request, params);
  if (is_far_along(request))
    return [&, X_MT](const Pose2& X_MB) {
      if ((X_MT.position() - X_MB.position()).norm() < kArrived)
        return Twist2{0.0, 1.5 * wrap_angle(X_MT.theta - X_MB.theta)};
      return drive_to(along(request.trail, X_MB.position(), kLookahead).p_MT, X_MB, robot);
    };
  return [X_MT, &robot](const Pose2& X_MB) -> Twist2 {
    if ((X_MT.position() - X_MB.position()).norm() > kArrived)
      return drive_to(X_MT.position(), X_MB, robot);
    return {0.0, 1.5 * wrap_angle(X_MT.theta - X_MB.theta)};
  };
}

// (1)
StageCost pose_cost(const PlanRequest& request, const Pose2& X_MB, std::size_t k,
                    const NmpcParams& params) {
  const double d = (request.X_MG.position() - X_MB.position()).norm(), d0 = params.heading_fade;
  const double fade = d0 > 0.0 ? d0 * d0 / (d0 * d0 + d * d) : 1.0;
  StageCost cost;
  cost.X_MR = leader_after(params.dt * static_cast<double>(k + 1), request, params);
  cost.q_x = params.weight_x;
  cost.q_y = params.weight_y;
  cost.q_theta = fade * params.weight_heading;
  cost.r_v = params.weight_v;
  cost.r_w = params.weight_w;
  cost.c_v = cost.c_w = params.weight_smooth;
  return cost;
}

// (4)
StageCost trail_cost(const PlanRequest& request, const Forecast& nominal, std::size_t k,
                     const NmpcParams& params) {
  StageCost cost = pose_cost(request, nominal.X_MB.front(), k, params);
  const OnTrail target = along(request.trail, nominal.X_MB[k + 1].position(), kLead);
  cost.X_MR.x = target.p_MT.x();
  cost.X_MR.y = target.p_MT.y();
  const double along_it = target.bridges ? 0.0 : params.weight_along;
  const double across = target.bridges ? 0.0 : params.weight_across;
  const double c = target.ahead.x(), s = target.ahead.y();
  cost.q_x = along_it * c * c + across * s * s;
  cost.q_y = along_it * s * s + across * c * c;
  cost.q_xy = (along_it - across) * c * s;
  return cost;
}

// (2)
StageCost rollout_cost(const Twist2& user, const Forecast& nominal, std::size_t k,
                       const Twist2& before, const NmpcParams& params) {
  StageCost cost;
  cost.X_MR = nominal.X_MB[k + 1];
  cost.twist = user;
  cost.change = {cost.twist.v - before.v, cost.twist.w - before.w};
  cost.q_x = cost.q_y = kIntentionScale * params.intention_position;
  cost.q_theta = kIntentionScale * params.intention_heading;
  cost.r_v = cost.r_w = kIntentionScale * params.intention_speed;
  cost.c_v = cost.c_w = kIntentionScale * params.intention_smooth;
  return cost;
}

void discount(StageCost& cost, double factor) {
  for (double* weight : {&cost.q_x, &cost.q_y, &cost.q_xy, &cost.q_theta, &cost.r_v, &cost.r_w,
                         &cost.c_v, &cost.c_w, &cost.c_dir})
    *weight *= factor;
}

// (3)
StageCost atan_cost(const Twist2& user, const NmpcParams& params) {
  StageCost cost;
  cost.twist = {user.v, 0.0};
  cost.r_v = kIntentionScale * params.intention_speed;
  cost.c_v = cost.c_w = kIntentionScale * params.intention_smooth;
  const bool has_direction = std::hypot(user.v, user.w) > 0.02;
  if (has_direction) {
    cost.c_dir = kIntentionScale * params.intention_heading;
    cost.direction = std::atan2(user.w, user.v);
  } else {
    cost.r_w = kIntentionScale * params.intention_heading;
  }
  return cost;
}

}  // namespace

Pose2 leader_after(double t, const PlanRequest& request, const NmpcParams& params) {
  const double T = params.leader_preview;
  if (request.method == Method::kGoal || T <= 0.0) return request.X_MG;
  return integrate(request.X_MG, request.user, T * (1.0 - std::exp(-t / T)));
}

std::vector<Eigen::Vector2d> leader_onward(const PlanRequest& request, const NmpcParams& params) {
  const double T = params.leader_preview;
  const double steps = std::floor(std::abs(request.user.v) * T / Trail::kSpacing);
  std::vector<Eigen::Vector2d> points;
  for (double i = 1.0; i <= steps; ++i)
    points.push_back(integrate(request.X_MG, request.user, T * i / steps).position());
  return points;
}

double braking_of(const PlanRequest& request, const RobotParams& robot) {
  const double asked = request.user.v * (request.command.v < 0.0 ? -1.0 : 1.0);
  const bool asks = request.method != Method::kGoal && request.user != Twist2{} &&
                    asked < kEases * std::abs(request.command.v);
  return asks ? std::max(robot.a_max, robot.a_brake) : robot.a_max;
}

Forecast forecast(const PlanRequest& request, const Moving& from, const NmpcParams& params,
                  const RobotParams& robot) {
  return roll_out(wanted_by(request, params, robot), request, from, params, robot);
}

Forecast forecast_via(const Eigen::Vector2d& p_MV, const PlanRequest& request, const Moving& from,
                      const NmpcParams& params, const RobotParams& robot) {
  const Wanted afterwards = wanted_by(request, params, robot);
  bool passed = false;
  const auto wanted = [&](const Pose2& X) {
    passed = passed || (p_MV - X.position()).norm() < 0.3;
    return passed ? afterwards(X) : drive_to(p_MV, X, robot);
  };
  return roll_out(wanted, request, from, params, robot);
}

Forecast forecast_of(const Twist2& twist, const PlanRequest& request, const Moving& from,
                     const NmpcParams& params, const RobotParams& robot) {
  return roll_out([&](const Pose2&) { return twist; }, request, from, params, robot);
}

std::vector<StageCost> stage_costs(const PlanRequest& request, const Forecast& nominal,
                                   const NmpcParams& params, const RobotParams& robot) {
  std::vector<StageCost> costs;
  Twist2 before = request.command;
  for (std::size_t k = 0; k < nominal.twist.size(); ++k) {
    if (is_far_along(request))
      costs.push_back(trail_cost(request, nominal, k, params));
    else if (request.method != Method::kIntention)
      costs.push_back(pose_cost(request, nominal.X_MB.front(), k, params));
    else if (params.intention_form == "atan")
      costs.push_back(atan_cost(request.user, params));
    else
      costs.push_back(rollout_cost(limit(request.user, robot), nominal, k, before, params));
    if (request.method == Method::kIntention)
      discount(costs.back(), std::exp(-params.dt * static_cast<double>(k) / kPatience));
    before = nominal.twist[k];
  }
  if (request.method == Method::kGoal) {
    for (double* weight : {&costs.back().q_x, &costs.back().q_y, &costs.back().q_theta})
      *weight *= 1.0 + params.terminal_weight;
  }
  return costs;
}

double pull(const std::vector<StageCost>& costs, const Pose2& X_MB, double dt) {
  double sum = 0.0;
  for (const StageCost& c : costs)
    sum += 2.0 * c.pull(c.X_MR.position() - X_MB.position()).norm() +
           2.0 * c.r_v * std::abs(c.twist.v) / dt / static_cast<double>(costs.size());
  return sum;
}

}  // namespace tandem
