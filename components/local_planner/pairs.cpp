// SPDX-License-Identifier: Apache-2.0
#include "local_planner/pairs.hpp"

#include <algorithm>

#include "local_planner/ellipse_distance.hpp"

namespace tandem {
namespace {

struct Candidate {
  double clearance;
  Pair pair;
};

// Pairs of the stage that ends at X_MB, `t` seconds after the obstacles' time, within reach.
std::vector<Candidate> within_reach(const Body& body, std::span<const Obstacle> obstacles,
                                    const Pose2& X_MB, double t, const PairLimits& limits) {
  std::vector<Candidate> found;
  for (const Obstacle& obstacle : obstacles) {
    const Obstacle there = predicted(obstacle, t);
    for (std::uint32_t i = 0; i < body.discs.size(); ++i) {
      const Disc& disc = body.discs[i];
      const Eigen::Vector2d p_MC = transform(X_MB, disc.p_BC);
      const double gap = disc.radius + limits.margin;
      if ((there.p_MO - p_MC).norm() > there.a + gap + limits.reach) continue;
      const double clearance = signed_distance(there, p_MC).value - gap;
      if (clearance < limits.reach) found.push_back({clearance, {disc.p_BC, gap, there, i}});
    }
  }
  return found;
}

}  // namespace

std::vector<std::vector<Pair>> nearest_pairs(const Body& body, std::span<const Obstacle> obstacles,
                                             std::span<const Pose2> X_MB,
                                             const PairLimits& limits) {
  std::vector<std::vector<Pair>> all;
  for (std::size_t k = 0; k < X_MB.size(); ++k) {
    const double t = limits.start + limits.dt * static_cast<double>(k + 1);
    auto found = within_reach(body, obstacles, X_MB[k], t, limits);
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.clearance < b.clearance; });
    found.resize(std::min(found.size(), static_cast<std::size_t>(limits.max_pairs)));
    all.emplace_back();
    for (const Candidate& candidate : found) all.back().push_back(candidate.pair);
  }
  return all;
}

std::vector<double> clearances(const Body& body, std::span<const Obstacle> obstacles,
                               std::span<const Pose2> X_MB, const PairLimits& limits) {
  std::vector<double> all;
  for (std::size_t k = 0; k < X_MB.size(); ++k) {
    const double t = limits.start + limits.dt * static_cast<double>(k + 1);
    double least = limits.reach;
    for (const Candidate& candidate : within_reach(body, obstacles, X_MB[k], t, limits))
      least = std::min(least, candidate.clearance);
    all.push_back(least);
  }
  return all;
}

}  // namespace tandem
