// SPDX-License-Identifier: Apache-2.0
// A polyline through the map, addressed by its arc length.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tandem {

/// A polyline of points in M [m].
class Route {
 public:
  /// Throws std::invalid_argument without a point or if two neighbours are the same.
  explicit Route(std::vector<Eigen::Vector2d> points);

  /// Length of the whole route [m].
  [[nodiscard]] double length() const { return length_.back(); }

  /// The point at arc length s [m]; the first and last segments are extended straight beyond the
  /// ends.
  [[nodiscard]] Eigen::Vector2d point_at(double s) const;

  /// Heading of the segment at s [rad].
  [[nodiscard]] double heading_at(double s) const;

  /// Arc length of the point nearest to `p_MQ` within [from, to], in [0, length()] [m].
  [[nodiscard]] double nearest(const Eigen::Vector2d& p_MQ, double from, double to) const;

 private:
  [[nodiscard]] std::size_t segment_at(double s) const;

  std::vector<Eigen::Vector2d> points_;
  std::vector<double> length_;  // arc length at each point [m]
};

}  // namespace tandem
