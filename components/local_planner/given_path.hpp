// SPDX-License-Identifier: Apache-2.0
// Keeps the part of a given path that the robot has not passed yet.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace tandem {

/// A path to follow, from the robot onward, in the map frame [m].
class GivenPath {
 public:
  static constexpr double kSpacing = 0.05;     ///< [m] between two points, roughly
  static constexpr double kSearchAhead = 2.0;  ///< [m] that the robot can pass in one cycle

  /// Replaces the path. The robot has passed none of it.
  void follow(std::span<const Eigen::Vector2d> path);
  /// The robot moved to p_MB: drops what it has passed.
  void advance(const Eigen::Vector2d& p_MB);
  void clear() { points_.clear(); }

  /// What the robot has not passed yet.
  [[nodiscard]] const std::vector<Eigen::Vector2d>& points() const { return points_; }
  /// Length of points() [m].
  [[nodiscard]] double length() const;

 private:
  std::vector<Eigen::Vector2d> points_;
};

/// Index of the point nearest to p within the first `most` [m] of the path.
[[nodiscard]] std::size_t nearest_index(std::span<const Eigen::Vector2d> points,
                                        const Eigen::Vector2d& p, double most);

}  // namespace tandem
