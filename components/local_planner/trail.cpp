// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/trail.hpp"

#include <algorithm>

#include "tandem/local_planner/given_path.hpp"

namespace tandem {
namespace {

constexpr double kJump = 0.5;        // [m] in a cycle: the leader was repositioned
constexpr double kSamePlace = 0.2;   // [m] from an earlier point: the leader has returned to it
constexpr std::size_t kRecent = 12;  // newest points, too close to count as a return
constexpr double kBridge = 0.15;     // [m] between two points: points between them were left out

}  // namespace

void Trail::extend(const Eigen::Vector2d& p_ML, const Eigen::Vector2d& p_MB) {
  if (points_.empty() || (p_ML - points_.back()).norm() > kJump) points_ = {p_MB};
  while ((p_ML - points_.back()).norm() >= kSpacing) {
    const Eigen::Vector2d next = points_.back() + kSpacing * (p_ML - points_.back()).normalized();
    for (std::size_t i = 0; i + kRecent < points_.size(); ++i)
      if ((points_[i] - next).norm() < kSamePlace) points_.resize(i + 1);
    if ((points_.back() - next).norm() > 1e-6) points_.push_back(next);
    if (points_.size() > 1000) break;
  }
  const auto passed =
      static_cast<std::ptrdiff_t>(nearest_index(points_, p_MB, GivenPath::kSearchAhead));
  points_.erase(points_.begin(), points_.begin() + passed);
}

std::vector<Eigen::Vector2d> Trail::free_points(const Body& body,
                                                std::span<const Obstacle> obstacles,
                                                const PairLimits& limits,
                                                std::span<const Eigen::Vector2d> onward) const {
  std::vector<Eigen::Vector2d> all = points_;
  all.insert(all.end(), onward.begin(), onward.end());
  return tandem::free_points(all, body, obstacles, limits);
}

std::vector<Eigen::Vector2d> free_points(std::span<const Eigen::Vector2d> points, const Body& body,
                                         std::span<const Obstacle> obstacles,
                                         const PairLimits& limits) {
  const Body disc{{}, {{{0.0, 0.0}, largest_radius(body)}}, true};
  PairLimits now = limits;
  now.dt = 0.0;
  std::vector<Eigen::Vector2d> free;
  for (const Eigen::Vector2d& p : points) {
    const Pose2 X{p.x(), p.y(), 0.0};
    if (&p == &points.back() || first_miss(disc, obstacles, std::span(&X, 1), now) == 1)
      free.push_back(p);
  }
  return free;
}

namespace {

// Direction of the trail around its i-th step, averaged because single steps are noisy.
Eigen::Vector2d direction(std::span<const Eigen::Vector2d> trail, std::size_t i) {
  constexpr std::size_t kSteps = 3;  // to either side
  const Eigen::Vector2d from = trail[i > kSteps ? i - kSteps : 0];
  const Eigen::Vector2d to = trail[std::min(i + 1 + kSteps, trail.size() - 1)];
  return (to - from).stableNormalized();
}

}  // namespace

OnTrail along(std::span<const Eigen::Vector2d> trail, const Eigen::Vector2d& p_MQ, double ahead) {
  std::size_t i = nearest_index(trail, p_MQ, 1e9);
  for (; i + 1 < trail.size(); ++i) {
    const Eigen::Vector2d step = trail[i + 1] - trail[i];
    const double length = step.norm();
    if (ahead < length)
      return {trail[i] + ahead / length * step, direction(trail, i), length > kBridge};
    ahead -= length;
  }
  return {trail[i], direction(trail, i)};
}

}  // namespace tandem
