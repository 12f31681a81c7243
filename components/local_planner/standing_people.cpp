// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/standing_people.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tandem/local_planner/ocp/pairs.hpp"

namespace tandem {
namespace {

constexpr double kReaction = 0.5;  // [s] that a person needs to let go of the stick, with a reserve
constexpr double kStraight = 0.15;  // share of w_max up to which the stick does not ask for a turn

bool stands(const Obstacle& obstacle) { return obstacle.tracked && !moves(obstacle); }

// [m] in which the robot stops if it begins to brake a reaction later.
double stopping_distance(const PlanRequest& request, double delay, const RobotParams& robot) {
  const double v = std::max(std::abs(request.command.v), std::abs(request.measured.v));
  return v * (delay + kReaction) + v * v / (2.0 * robot.a_max);
}

}  // namespace

std::vector<Obstacle> obstacles_of_the_plan(const PlanRequest& request, const Body& body,
                                            const NmpcParams& params, const RobotParams& robot) {
  std::vector<Obstacle> kept(request.obstacles.begin(), request.obstacles.end());
  const bool straight = std::abs(request.user.w) <= kStraight * robot.w_max;
  if (request.method != Method::kIntention || !straight) return kept;
  const double near = stopping_distance(request, params.delay, robot);
  const PairLimits at_once{
      .margin = params.margin, .dt = 0.0, .reach = std::numeric_limits<double>::max()};
  std::erase_if(kept, [&](const Obstacle& o) {
    return stands(o) && clearances(body, {&o, 1}, {&request.X_MB, 1}, at_once).front() > near;
  });
  return kept;
}

}  // namespace tandem
