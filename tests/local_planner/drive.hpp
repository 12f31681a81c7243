// SPDX-License-Identifier: Apache-2.0
// Runs planner and robot in closed loop without DDS, and reports what happened.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "tandem/local_planner/motion_check.hpp"
#include "tandem/local_planner/nmpc.hpp"
#include "tandem/model/diff_drive.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem::test {

/// Devalla's forest: sixteen poles and, optionally, four walls as thin ellipses.
inline std::vector<Obstacle> forest(bool walls, double radius = 0.225) {
  const double x[] = {-4, -2, 0.5, 3, -2.5, 0, 2, -4, -1, 3, -2, 1, 4, -1, 1, 3};
  const double y[] = {3.5, 3, 3.5, 4, 1.5, 1.5, 2, 0, 0, 0.5, -2, -1, -1, -4, -3, -3};
  std::vector<Obstacle> all;
  std::uint32_t id = 1;
  for (int i = 0; i < 16; ++i) all.push_back({id++, {x[i], y[i]}, radius, radius, 0.0, {0, 0}});
  if (!walls) return all;
  for (const double side : {-1.0, 1.0})
    for (const double at : {-3.75, -1.25, 1.25, 3.75}) {
      all.push_back({id++, {at, side * 5.0}, 1.5, 0.1, 0.0, {0, 0}});
      all.push_back({id++, {side * 5.0, at}, 1.5, 0.1, std::numbers::pi / 2, {0, 0}});
    }
  return all;
}

/// The robot of these tests: a command acts after `delay`, and the motors follow with a first-order
/// lag.
struct Plant {
  Pose2 X_MB;
  Twist2 twist;
  double delay = 0.0, lag = 0.0;
  std::vector<Twist2> pending = {};

  void run(const Twist2& command, double period) {
    constexpr int kSubsteps = 10;
    const double h = period / kSubsteps;
    const auto waiting = static_cast<std::size_t>(std::lround(delay / h));
    while (pending.size() < waiting) pending.push_back(twist);
    for (int i = 0; i < kSubsteps; ++i) {
      pending.push_back(command);
      const Twist2 now = pending.front();
      pending.erase(pending.begin());
      const double gain = lag > 0.0 ? 1.0 - std::exp(-h / lag) : 1.0;
      twist = {twist.v + gain * (now.v - twist.v), twist.w + gain * (now.w - twist.w)};
      X_MB = integrate(X_MB, twist, h);
    }
    X_MB.theta = wrap_angle(X_MB.theta);
  }
};

struct Drive {
  std::vector<Pose2> path = {};
  std::vector<double> solve_times = {};
  std::vector<int> iterations = {};
  std::vector<Plan> plans = {};
  int fallbacks = 0;
  int contacts = 0;         ///< cycles that end in contact
  double worst_rate = 0.0;  ///< largest ratio of a command's change to the permitted change

  [[nodiscard]] double percentile(double p) const {
    auto sorted = solve_times;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(p * static_cast<double>(sorted.size() - 1))];
  }
};

/// The person's input at time t with the robot at X_MB: fills the request's reference.
using Person = std::function<void(double t, const Plant& plant, PlanRequest& request)>;

inline Drive drive(const NmpcParams& params, const RobotParams& robot, Plant plant,
                   std::vector<Obstacle> obstacles, double seconds, const Person& person) {
  Nmpc planner(params, robot);
  Body body{footprint_of(robot), {{{0.0, 0.0}, params.disc_radius}}, params.disc_radius > 0.0};
  Drive out;
  Twist2 command;
  for (double t = 0.0; t < seconds; t += params.control_period) {
    PlanRequest request{.t = t, .X_MB = plant.X_MB, .command = command, .measured = plant.twist};
    request.obstacles = obstacles;
    person(t, plant, request);
    Plan plan = planner.solve(request);
    if (plan.source != PlanSource::kBraking)
      out.worst_rate = std::max({out.worst_rate, std::abs(plan.command.v - command.v) / robot.a_max,
                                 std::abs(plan.command.w - command.w) / robot.alpha_max});
    command = plan.command;
    plant.run(command, params.control_period);
    for (Obstacle& obstacle : obstacles) obstacle.p_MO += params.control_period * obstacle.v_MO;
    out.path.push_back(plant.X_MB);
    out.solve_times.push_back(plan.solve_time);
    out.iterations.push_back(plan.iterations);
    out.fallbacks += static_cast<int>(plan.status) < 0 ? 1 : 0;
    for (const Obstacle& obstacle : obstacles)
      if (touches(body, plant.X_MB, obstacle)) {
        ++out.contacts;
        break;
      }
    out.plans.push_back(std::move(plan));
  }
  return out;
}

/// A person who drives a leader along waypoints at constant speed, at most `leash` ahead.
inline Person leader_along(std::vector<Eigen::Vector2d> p_MW, double speed, double leash) {
  auto next = std::make_shared<std::size_t>(0);
  auto leader = std::make_shared<std::optional<Pose2>>();
  auto last = std::make_shared<double>(0.0);
  return [=](double t, const Plant& plant, PlanRequest& request) {
    if (!*leader) *leader = plant.X_MB;
    Pose2& X = **leader;
    const double step = speed * (t - *last);
    *last = t;
    const Eigen::Vector2d to = p_MW[*next] - X.position();
    if (to.norm() < 0.3 && *next + 1 < p_MW.size()) ++*next;
    if (to.norm() > 0.05) {
      X.theta = std::atan2(to.y(), to.x());
      X.x += std::min(step, to.norm()) * std::cos(X.theta);
      X.y += std::min(step, to.norm()) * std::sin(X.theta);
    }
    const Eigen::Vector2d away = X.position() - plant.X_MB.position();
    if (away.norm() > leash) {
      X.x = plant.X_MB.x + leash * away.x() / away.norm();
      X.y = plant.X_MB.y + leash * away.y() / away.norm();
    }
    request.method = Method::kLeader;
    request.X_MG = X;
    request.user = {to.norm() > 0.05 ? speed : 0.0, 0.0};
  };
}

}  // namespace tandem::test
