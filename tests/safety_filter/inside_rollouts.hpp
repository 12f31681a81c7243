// SPDX-License-Identifier: Apache-2.0
// Rollouts that start closer to an obstacle than the filter's margin, by the measured pose or only
// by the true one, with errors of the pose that may change at every measurement.
#pragma once

#include "safety_filter/rollouts.hpp"

namespace tandem::test {

/// Poles, single cells or tight boxes in a small room.
inline CellWorld small_world(Random& random) {
  const double side =
      std::array{0.02, 0.05, 0.05, 0.1, 0.2}[static_cast<std::size_t>(pick(random, 5))];
  const double size = 6.0, edge = 0.5 * size - 2.0 * side;
  CellWorld world(size, side);
  const int kind = pick(random, 3);
  const double box = uniform(random, 0.7, 2.5);
  std::vector<std::array<double, 3>> discs;
  for (int i = 0; i < (kind == 0 ? 12 : kind == 1 ? 40 : 0); ++i)
    discs.push_back({uniform(random, -2.8, 2.8), uniform(random, -2.8, 2.8),
                     kind == 1 ? 0.6 * side : uniform(random, 0.05, 0.5)});
  world.add_where([&](double x, double y) {
    const bool is_box = (std::fmod(std::abs(x), box) < side && std::fmod(std::abs(y), 3.0) > 0.8) ||
                        (std::fmod(std::abs(y), box) < side && std::fmod(std::abs(x), 3.0) > 0.8);
    return std::max(std::abs(x), std::abs(y)) > edge || (kind == 2 && is_box) ||
           std::any_of(discs.begin(), discs.end(), [&](const auto& disc) {
             return std::hypot(x - disc[0], y - disc[1]) < disc[2];
           });
  });
  world.sort_into_buckets();
  return world;
}

/// A placement whose clearance is `clearance`, found by moving in a random direction; nullopt if
/// that meets nothing.
inline std::optional<Placement> place_near(const Outline& outline, const CellWorld& world,
                                           double clearance, Random& random) {
  constexpr double kClose = 1e-4;  // [m]
  auto at = free_place(outline, world, 0.05, random);
  const double angle = uniform(random, -std::numbers::pi, std::numbers::pi);
  for (int i = 0; at && i < 800; ++i) {
    const double left = clearance_bound(outline, *at, world, 0.5) - clearance;
    if (left <= kClose) return left > -kClose ? at : std::nullopt;
    const double step = 0.95 * std::max(left, kClose);
    at->x += step * std::cos(angle);
    at->y += step * std::sin(angle);
  }
  return std::nullopt;
}

/// The part of the hard margin that no error of the pose uses up [m]: as near as this a robot may
/// stop.
inline double least_rest(const SafetyFilterParams& params) {
  return params.reserve + 0.5 * kCheckSpacing;
}

/// Up to 40 rollouts with the world and the robot of that seed, each from a clearance between
/// least_rest() and the hard margin.
[[nodiscard]] inline Tally run_inside_scene(unsigned seed) {
  Tally tally;
  Random random(seed);
  const SafetyFilterParams params = any_filter(random);
  const RobotParams robot = any_robot(random);
  const CellWorld world = small_world(random);
  Loop loop(params, robot, world, {}, random);
  const double margin = SafetyFilter{params, robot}.hard_margin();
  for (int i = 0; i < 40; ++i) {
    const double clearance = uniform(random, least_rest(params), margin);
    const auto start = place_near(loop.base().outline(), world, clearance, random);
    if (!start) continue;
    loop.start_at(*start);
    Attack attack(static_cast<Plan>(pick(random, kPlans)), robot, world, random);
    roll_out(loop, attack, params, random, tally, 2.0);
    tally.contacts += loop.base().touched() ? 1 : 0;
  }
  finish_scene(tally, loop, seed);
  return tally;
}

}  // namespace tandem::test
