// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/pairs.hpp"

#include <algorithm>
#include <cmath>

#include "tandem/local_planner/ocp/signed_distance.hpp"

namespace tandem {
namespace {

struct NearPair {
  double clearance;  // [m]
  std::uint32_t disc;
  std::size_t obstacle;
};

// Distances between body and obstacles at many poses. Most pairs are far apart, so circles around
// both and the obstacle's bounding box are tested before the exact distance.
class Surroundings {
 public:
  Surroundings(const Body& body, std::span<const Obstacle> obstacles, const PairLimits& limits)
      : body_{body}, obstacles_{obstacles}, limits_{limits} {
    for (const Disc& disc : body.discs) radius_ = std::max(radius_, disc.p_BC.norm() + disc.radius);
    for (const Obstacle& obstacle : obstacles) {
      axes_.emplace_back(std::cos(obstacle.angle), std::sin(obstacle.angle));
      margins_.push_back(limits.margin + (moves(obstacle) ? limits.moving : 0.0));
    }
  }

  // Calls found({clearance, disc, obstacle}) for each pair with less clearance than `most` at the
  // pose X_MB, `t` seconds after the obstacles' timestamp. `found` may lower `most` between calls.
  template <class Found>
  void closer_than(const double& most, const Pose2& X_MB, double t, const Found& found) const {
    const double c = std::cos(X_MB.theta), s = std::sin(X_MB.theta);
    for (std::size_t j = 0; j < obstacles_.size(); ++j) {
      const Eigen::Vector2d p_MO = obstacles_[j].p_MO + t * obstacles_[j].v_MO;
      const double near = most + margins_[j] + circumradius(obstacles_[j]) + radius_;
      if (near <= 0.0 || (p_MO - X_MB.position()).squaredNorm() >= near * near) continue;
      Obstacle there = obstacles_[j];
      there.p_MO = p_MO;
      for (std::uint32_t i = 0; i < body_.discs.size(); ++i) {
        const Disc& disc = body_.discs[i];
        const Eigen::Vector2d p_MC{X_MB.x + c * disc.p_BC.x() - s * disc.p_BC.y(),
                                   X_MB.y + s * disc.p_BC.x() + c * disc.p_BC.y()};
        const double gap = disc.radius + margins_[j];
        if (is_beyond(most + gap, there, axes_[j], p_MC - p_MO)) continue;
        const double clearance = signed_distance(there, axes_[j], p_MC).value - gap;
        if (clearance < most) found({clearance, i, j});
      }
    }
  }

  [[nodiscard]] Pair pair(const NearPair& near, double t) const {
    const Disc& disc = body_.discs[near.disc];
    return {disc.p_BC, disc.radius + margins_[near.obstacle],
            predicted(obstacles_[near.obstacle], t), near.disc};
  }

  [[nodiscard]] double least_clearance(const Pose2& X_MB, double t, double least) const {
    closer_than(least, X_MB, t, [&](const NearPair& near) { least = near.clearance; });
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
  double radius_ = 0.0;                // [m] of a circle about base_link around all discs
  std::vector<Eigen::Vector2d> axes_;  // cosine and sine of each obstacle's angle
  std::vector<double> margins_;        // [m]
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
    const double t = around.time(k);
    around.closer_than(most, X_MB[k], t, [&](const NearPair& near) {
      const auto is_nearer = [](const NearPair& a, const NearPair& b) {
        return a.clearance < b.clearance;
      };
      nearest.insert(std::upper_bound(nearest.begin(), nearest.end(), near, is_nearer), near);
      if (nearest.size() > count) nearest.pop_back();
      if (nearest.size() == count) most = nearest.back().clearance;
    });
    all.emplace_back();
    all.back().reserve(nearest.size());
    for (const NearPair& near : nearest) all.back().push_back(around.pair(near, t));
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
