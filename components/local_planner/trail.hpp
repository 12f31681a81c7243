// SPDX-License-Identifier: Apache-2.0
// Records the leader's path from the robot onward, for method path.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tandem/local_planner/ocp/pairs.hpp"

namespace tandem {

/// The part of the leader's path that the robot has not passed yet, in the map frame [m]. After
/// Devalla 2020, §5.1: the leader's path, not only its pose, expresses what the person wants.
class Trail {
 public:
  /// The leader moved to p_ML, the robot to p_MB. A leader that returns to an earlier point of its
  /// trail removes the loop between; a leader that jumps starts a new trail at the robot.
  void extend(const Eigen::Vector2d& p_ML, const Eigen::Vector2d& p_MB);
  void clear() { points_.clear(); }

  /// The trail's points, kSpacing apart, followed by `onward`. Points at which the body's largest
  /// disc would violate the margin are left out, except the last: the leader is virtual and drives
  /// through obstacles.
  [[nodiscard]] std::vector<Eigen::Vector2d> free_points(
      const Body& body, std::span<const Obstacle> obstacles, const PairLimits& limits,
      std::span<const Eigen::Vector2d> onward = {}) const;

  static constexpr double kSpacing = 0.05;  ///< [m]

 private:
  std::vector<Eigen::Vector2d> points_;
};

/// Those of the points, as a trail, at which the body's largest disc keeps the margin, and the
/// last.
[[nodiscard]] std::vector<Eigen::Vector2d> free_points(std::span<const Eigen::Vector2d> points,
                                                       const Body& body,
                                                       std::span<const Obstacle> obstacles,
                                                       const PairLimits& limits);

/// A point on a trail, in the map frame [m].
struct OnTrail {
  Eigen::Vector2d p_MT;
  Eigen::Vector2d ahead = {1.0, 0.0};  ///< unit vector of the trail's direction there
  bool bridges = false;  ///< the point lies in a gap of the trail, left by an obstacle
};
/// The point `ahead` [m] along the trail from its point nearest to p_MQ; at most the last point.
/// `trail` must not be empty.
[[nodiscard]] OnTrail along(std::span<const Eigen::Vector2d> trail, const Eigen::Vector2d& p_MQ,
                            double ahead);

}  // namespace tandem
