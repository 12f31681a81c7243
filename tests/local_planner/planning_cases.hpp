// SPDX-License-Identifier: Apache-2.0
// Draws a planner, a world and a request from a seed, with the resulting problems and initial
// guesses.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tandem/local_planner/cycle.hpp"
#include "tandem/local_planner/ocp/signed_distance.hpp"
#include "tandem/local_planner/trail.hpp"
#include "tandem/local_planner/warm_start.hpp"

namespace tandem::test {

struct Random {
  std::mt19937 generator;
  double operator()(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(generator);
  }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(generator) == 1; }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(generator); }
};

/// A planner's parameters and one request.
struct PlanningCase {
  NmpcParams params = {};
  RobotParams robot = {};
  PlanRequest request = {};
  std::vector<Obstacle> obstacles = {};
  std::vector<Eigen::Vector2d> way = {};  ///< kPath: the path that the leader has driven so far
};

/// An S-shaped path from the robot to X_MG.
inline std::vector<Eigen::Vector2d> leaders_way(const PlanRequest& request, double bulge) {
  const Eigen::Vector2d from = request.X_MB.position(), all = request.X_MG.position() - from;
  const Eigen::Vector2d aside{-bulge * all.y(), bulge * all.x()};
  std::vector<Eigen::Vector2d> way;
  for (double s = 0.0; s <= 1.0; s += 0.02)
    way.push_back(from + s * all + std::sin(2.0 * std::numbers::pi * s) * aside);
  return way;
}

/// Varies everything: method, model, horizon, discs, lag (in one case of four), state, reference,
/// and circles, ellipses and rectangles at rest and moving. One case in four may start inside
/// obstacles.
inline PlanningCase random_case(unsigned seed) {
  Random random{std::mt19937(seed)};
  PlanningCase c;
  c.params.time_budget = 0.0;
  if (random.one_in(4)) c.params.horizon_steps = 10 + random.below(30);
  c.params.disc_overhang = std::array{
      1.0, 0.08, 0.037, 0.021}[static_cast<std::size_t>(random.below(4))];  // 1 … 4 discs
  c.params.model = random.one_in(4) ? "euler" : "arc";
  c.params.intention_form = random.one_in(3) ? "atan" : "rollout";
  c.params.max_pairs = random.one_in(3) ? 12 : 6;
  if (random.one_in(5)) c.params.workspace = 4.2;
  if (seed % 4 == 3) {
    c.params.lag_v = 0.1 * static_cast<double>(seed % 7);
    c.params.lag_w = 0.05 + 0.1 * static_cast<double>(seed % 5);
  }

  PlanRequest& request = c.request;
  request.method = static_cast<Method>(random.below(4));
  request.X_MB = {random(-3, 3), random(-3, 3), random(-3.1, 3.1)};
  if (!random.one_in(3)) request.command = {random(-0.4, 0.8), random(-1, 1)};
  request.measured = {request.command.v + random(-0.05, 0.05),
                      request.command.w + random(-0.05, 0.05)};
  const double bearing = random(-3.1, 3.1);
  const double distance = random(0.0, request.method == Method::kLeader ? 1.2 : 5.0);
  request.X_MG = {request.X_MB.x + distance * std::cos(bearing),
                  request.X_MB.y + distance * std::sin(bearing), random(-3.1, 3.1)};
  request.user = random.one_in(2) ? Twist2{0.6, 0.0} : Twist2{random(-0.4, 0.8), random(-1, 1)};

  const Body body = body_of(c.params, c.robot);
  const bool inside = random.one_in(4);
  const int count = random.below(20);
  for (int i = 0; i < count; ++i) {
    Obstacle obstacle{.id = static_cast<std::uint32_t>(i + 1), .a = random(0.1, 0.6)};
    obstacle.b = random.one_in(2) ? obstacle.a : random(0.08, obstacle.a);
    if (random.one_in(8)) obstacle.a = random(0.5, 2.5), obstacle.b = 0.1;  // a wall
    if (i % 3 == 2) obstacle.shape = ObstacleShape::kRectangle;
    obstacle.angle = random(-3, 3);
    obstacle.p_MO = {request.X_MB.x + random(-3.5, 3.5), request.X_MB.y + random(-3.5, 3.5)};
    if (random.one_in(6)) obstacle.v_MO = {random(-0.6, 0.6), random(-0.6, 0.6)};
    const bool touched = std::any_of(body.discs.begin(), body.discs.end(), [&](const Disc& disc) {
      return signed_distance(obstacle, transform(request.X_MB, disc.p_BC)).value < disc.radius;
    });
    if (!touched || inside) c.obstacles.push_back(obstacle);
  }
  if (request.method == Method::kPath) c.way = leaders_way(request, random(-0.25, 0.25));
  return c;
}

/// The initial guess of a solve.
enum class Begin {
  kCold,   ///< the nominal trajectory, cut off before the first obstacle
  kBlind,  ///< the nominal trajectory, through all obstacles
  kWarm,   ///< the last solution, shifted by one control period
  kMoved,  ///< the same, with robot and obstacles moved by 5 to 30 mm and another nominal
           ///< trajectory
};
inline constexpr Begin kBegins[] = {Begin::kCold, Begin::kBlind, Begin::kWarm, Begin::kMoved};

inline const char* name(Begin begin) {
  constexpr const char* kNames[] = {"cold", "blind", "warm", "moved"};
  return kNames[static_cast<int>(begin)];
}

struct StartingPoint {
  Ocp ocp;
  Iterate guess;
};

/// The trail of a leader that drove the case's path and is now at the request's X_MG.
inline std::vector<Eigen::Vector2d> trail_of(const PlanningCase& c, const PlanRequest& request,
                                             const Body& body) {
  if (request.method != Method::kPath) return {};
  Trail trail;
  for (const Eigen::Vector2d& p_ML : c.way) trail.extend(p_ML, c.request.X_MB.position());
  trail.extend(request.X_MG.position(), request.X_MB.position());
  return trail.free_points(body, request.obstacles, {.margin = c.params.margin},
                           leader_onward(request, c.params));
}

/// Problem and initial guess of the first cycle.
inline StartingPoint first_problem(const PlanningCase& c, bool blind) {
  const Body body = body_of(c.params, c.robot);
  PlanRequest request = c.request;
  request.obstacles = c.obstacles;
  const std::vector<Eigen::Vector2d> trail = trail_of(c, request, body);
  request.trail = trail;
  const Cycle cycle = begin_cycle(request, c.params, c.robot, body);
  const Forecast guess = cold_guess(cycle);
  Ocp ocp = problem(cycle, guess);
  Iterate point = cold_start(ocp, rate(cycle, ocp, blind ? cycle.nominal : guess).motion);
  return {std::move(ocp), std::move(point)};
}

/// The same one control period after `last` was solved, with small perturbations if `moved`.
inline StartingPoint next_problem(const PlanningCase& c, const Solved& last, bool moved,
                                  unsigned seed) {
  Random random{std::mt19937(seed)};
  const double period = c.params.control_period;
  const Body body = body_of(c.params, c.robot);
  PlanRequest request = c.request;
  std::vector<Obstacle> obstacles = c.obstacles;
  const Twist2 u{last.point.z[kV], last.point.z[kW]};
  request.t += period;
  request.X_MB = integrate(request.X_MB, u, period);
  request.command = request.measured = u;
  request.X_MG.x += random(-0.03, 0.03);
  for (Obstacle& obstacle : obstacles) obstacle.p_MO += period * obstacle.v_MO;
  if (moved) {
    const double off = random(0.005, 0.03);
    const auto push = [&] {
      const double angle = random(-3.1, 3.1);
      return Eigen::Vector2d{off * std::cos(angle), off * std::sin(angle)};
    };
    const Eigen::Vector2d robot = push();
    request.X_MB.x += robot.x();
    request.X_MB.y += robot.y();
    for (Obstacle& obstacle : obstacles) obstacle.p_MO += push();
    request.X_MG.y += random(-0.2, 0.2);
    request.user.w += random(-0.3, 0.3);
  }
  request.obstacles = obstacles;
  const std::vector<Eigen::Vector2d> trail = trail_of(c, request, body);
  request.trail = trail;
  const Cycle cycle = begin_cycle(request, c.params, c.robot, body);
  const Ocp nominal = problem(cycle, cycle.nominal);
  Ocp ocp = problem(cycle, shifted_motion(last, period, nominal));
  Iterate point = warm_start(last, period, ocp);
  return {std::move(ocp), std::move(point)};
}

}  // namespace tandem::test
