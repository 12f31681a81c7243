// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/pairs.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/local_planner/ocp/ellipse_distance.hpp"

namespace tandem {
namespace {

constexpr double kMoves = 0.05;  // [m/s] faster obstacles count as moving

// Distances between body and obstacles at many poses. Most pairs are far apart, so the ellipse's
// bounding box is tested before the exact distance.
class Surroundings {
 public:
  Surroundings(const Body& body, std::span<const Obstacle> obstacles, const PairLimits& limits)
      : body_{body}, obstacles_{obstacles}, limits_{limits} {
    for (const Obstacle& obstacle : obstacles) {
      axes_.emplace_back(std::cos(obstacle.angle), std::sin(obstacle.angle));
      margins_.push_back(limits.margin + (obstacle.v_MO.norm() > kMoves ? limits.moving : 0.0));
    }
  }

  // Calls found(clearance, pair) for each pair with less clearance than `most` at the pose X_MB,
  // `t` seconds after the obstacles' timestamp. `found` may lower `most` between calls.
  template <class Found>
  void closer_than(const double& most, const Pose2& X_MB, double t, const Found& found) const {
    const double c = std::cos(X_MB.theta), s = std::sin(X_MB.theta);
    for (std::size_t j = 0; j < obstacles_.size(); ++j) {
      const Obstacle there = predicted(obstacles_[j], t);
      for (std::uint32_t i = 0; i < body_.discs.size(); ++i) {
        const Disc& disc = body_.discs[i];
        const Eigen::Vector2d p_MC{X_MB.x + c * disc.p_BC.x() - s * disc.p_BC.y(),
                                   X_MB.y + s * disc.p_BC.x() + c * disc.p_BC.y()};
        const double gap = disc.radius + margins_[j];
        if (is_beyond(most + gap, there, axes_[j], p_MC - there.p_MO)) continue;
        const double clearance = signed_distance(there, axes_[j], p_MC).value - gap;
        if (clearance < most) found(clearance, Pair{disc.p_BC, gap, there, i});
      }
    }
  }

  [[nodiscard]] double least_clearance(const Pose2& X_MB, double t, double least) const {
    closer_than(least, X_MB, t, [&](double clearance, const Pair&) { least = clearance; });
    return least;
  }

  [[nodiscard]] double time(std::size_t stage) const {
    return limits_.start + limits_.dt * static_cast<double>(stage + 1);
  }

 private:
  static bool is_beyond(double distance, const Obstacle& obstacle, const Eigen::Vector2d& axis,
                        const Eigen::Vector2d& p) {
    const double x = std::abs(axis.x() * p.x() + axis.y() * p.y()) - obstacle.a;
    const double y = std::abs(axis.x() * p.y() - axis.y() * p.x()) - obstacle.b;
    const double dx = std::max(0.0, x), dy = std::max(0.0, y);
    return dx * dx + dy * dy > 0.0 && dx * dx + dy * dy >= distance * std::abs(distance);
  }

  const Body& body_;
  std::span<const Obstacle> obstacles_;
  const PairLimits& limits_;
  std::vector<Eigen::Vector2d> axes_;  // cosine and sine of each obstacle's angle
  std::vector<double> margins_;        // [m]
};

struct NearPair {
  double clearance;
  Pair pair;
};

}  // namespace

std::vector<std::vector<Pair>> nearest_pairs(const Body& body, std::span<const Obstacle> obstacles,
                                             std::span<const Pose2> X_MB,
                                             const PairLimits& limits) {
  const Surroundings around{body, obstacles, limits};
  const auto count = static_cast<std::size_t>(limits.max_pairs);
  std::vector<std::vector<Pair>> all;
  std::vector<NearPair> nearest;
  for (std::size_t k = 0; k < X_MB.size(); ++k) {
    nearest.clear();
    double most = limits.reach;  // [m] a pair must be closer than this to be kept
    around.closer_than(most, X_MB[k], around.time(k), [&](double clearance, const Pair& pair) {
      const auto is_nearer = [](double c, const NearPair& other) { return c < other.clearance; };
      const auto place = std::upper_bound(nearest.begin(), nearest.end(), clearance, is_nearer);
      nearest.insert(place, {clearance, pair});
      if (nearest.size() > count) nearest.pop_back();
      if (nearest.size() == count) most = nearest.back().clearance;
    });
    all.emplace_back();
    for (const NearPair& near : nearest) all.back().push_back(near.pair);
  }
  return all;
}

std::vector<double> clearances(const Body& body, std::span<const Obstacle> obstacles,
                               std::span<const Pose2> X_MB, const PairLimits& limits) {
  const Surroundings around{body, obstacles, limits};
  std::vector<double> all;
  for (std::size_t k = 0; k < X_MB.size(); ++k)
    all.push_back(around.least_clearance(X_MB[k], around.time(k), limits.reach));
  return all;
}

std::size_t first_miss(const Body& body, std::span<const Obstacle> obstacles,
                       std::span<const Pose2> X_MB, const PairLimits& limits) {
  const Surroundings around{body, obstacles, limits};
  std::size_t k = 0;
  while (k < X_MB.size() && around.least_clearance(X_MB[k], around.time(k), 0.0) >= 0.0) ++k;
  return k;
}

}  // namespace tandem
