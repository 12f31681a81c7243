// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/fallback.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

// The smaller magnitude of both, as `command` may be braking already; zero if the signs differ.
double eased(double command, double braked) {
  const double least = std::min(std::abs(command), std::abs(braked));
  return command * braked > 0.0 ? std::copysign(least, command) : 0.0;
}

}  // namespace

Motion rest_of(const Plan& plan, const Start& start, double period, const RobotParams& robot) {
  Motion motion{.X_MB = start.X_MB, .dt = period};
  const double end = plan.t0 + plan.dt * static_cast<double>(plan.twist.size());
  Twist2 u = start.command;
  for (double t = start.t0; t < end || u != Twist2{}; t += period) {
    const Twist2 target = plan.at(t);
    u = {approach(u.v, target.v, robot.a_max * period),
         approach(u.w, target.w, robot.alpha_max * period)};
    motion.twist.push_back(u);
    if (motion.twist.size() >= 1000) break;  // a command far beyond the limits
  }
  return motion;
}

Motion braking(const Start& start, double period, double a, double alpha) {
  Motion motion{.X_MB = start.X_MB, .dt = period};
  const double duration =
      std::max(std::abs(start.command.v) / a, std::abs(start.command.w) / alpha);
  const int steps = std::clamp(static_cast<int>(std::ceil(duration / period)), 1, 1000);
  for (int i = 1; i <= steps; ++i) {
    const double left = std::max(0.0, 1.0 - i * period / std::max(duration, period));
    motion.twist.push_back({left * start.command.v, left * start.command.w});
  }
  motion.twist.back() = {};
  return motion;
}

Motion with_lag(Motion motion, const MotorLag& lag, const Twist2& moves) {
  motion.lag = lag;
  motion.moves = moves;
  for (double t = 0.0; t < coasting_time(lag); t += motion.dt) motion.twist.emplace_back();
  return motion;
}

double stopping_time(const Twist2& twist, const RobotParams& robot) {
  return std::max(std::abs(twist.v) / robot.a_max, std::abs(twist.w) / robot.alpha_max);
}

Plan to_plan(const Motion& motion, double t0) {
  Plan plan{.command = motion.twist.front(), .t0 = t0, .dt = motion.dt, .X_MB = {motion.X_MB}};
  plan.twist = motion.twist;
  Moving at{motion.X_MB, motion.moves};
  for (const Twist2& u : motion.twist) {
    at = follow(at, u, motion.lag, motion.dt);
    plan.X_MB.push_back(at.X_MB);
  }
  return plan;
}

Plan resting(const PlanRequest& request, double delay, double period, const RobotParams& robot) {
  const double latest = period + delay + robot.motor_lag;
  const Start start{request.X_MB, request.measured, request.t + delay};
  Plan plan = to_plan(braking(start, latest, std::max(robot.a_max, robot.a_brake),
                              std::max(robot.alpha_max, robot.alpha_brake)),
                      start.t0);
  plan.status = PlanStatus::kOptimal;
  plan.source = PlanSource::kResting;
  plan.command = {eased(request.command.v, plan.command.v),
                  eased(request.command.w, plan.command.w)};
  return plan;
}

}  // namespace tandem
