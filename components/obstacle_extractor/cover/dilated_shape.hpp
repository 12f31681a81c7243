// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. The places at which a disc touches a shape, row by row.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>

#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/bounding_shapes.hpp"

namespace tandem {

/// Interval of x; empty if left > right.
struct RowExtent {
  double left, right;
};

// A shape dilated by a disc of `radius` [m], about its centre, in units of `step` [m]: the centres
// of the discs that touch the shape. Slightly too small, which is accurate enough for a cost.
// `reach()` is its largest |y|, `row(y)` its extent in x at height y.

/// An ellipse of which the dilated ellipse is a superset: its axes are longer by the disc's radius
/// (the support function of the sum is larger).
class DilatedEllipse {
 public:
  /// `along`: unit vector of the shape's length.
  DilatedEllipse(const Obstacle& shape, const Eigen::Vector2d& along, double radius, double step);

  [[nodiscard]] double reach() const { return reach_; }

  // In the ellipse xᵀQx ≤ 1 the row at height y contains the x with
  //   Qxx x² + 2 Qxy x y + Qyy y² ≤ 1.
  [[nodiscard]] RowExtent row(double y) const {
    const double root = qxy_ * qxy_ * y * y - qxx_ * (qyy_ * y * y - 1.0);
    if (root <= 0.0) return {0.0, -1.0};
    const double middle = -qxy_ * y * per_, half = std::sqrt(root) * per_;
    return {middle - half, middle + half};
  }

 private:
  double qxx_, qyy_, qxy_, per_, reach_;
};

/// A polygon inside the dilated rectangle: two chords replace the arc at each corner.
class DilatedRectangle {
 public:
  DilatedRectangle(const Obstacle& shape, const Eigen::Vector2d& along, double radius, double step);

  [[nodiscard]] double reach() const { return reach_; }
  [[nodiscard]] RowExtent row(double y) const;

 private:
  std::array<Eigen::Vector2d, 12> vertices_;
  double reach_;
};

/// A polygon inside the dilated convex hull of at least three points, counter-clockwise: two chords
/// replace the arc at each corner.
class DilatedHull {
 public:
  DilatedHull(const Points& hull, double radius, double step);

  /// What `row` is relative to, the middle of the hull's height, in metres.
  [[nodiscard]] const Eigen::Vector2d& p_MC() const { return p_MC_; }
  [[nodiscard]] double reach() const { return reach_; }
  /// Fastest if the rows are asked for in their order.
  [[nodiscard]] RowExtent row(double y) const {
    if (y < right_.bottom() || y > right_.top()) return {0.0, -1.0};
    return {left_.x_at(y), right_.x_at(y)};
  }

 private:
  // One side of the polygon, upwards.
  class Side {
   public:
    explicit Side(Points line = {}) : line_{std::move(line)} {}
    [[nodiscard]] double bottom() const { return line_.front().y(); }
    [[nodiscard]] double top() const { return line_.back().y(); }
    [[nodiscard]] double x_at(double y) const;

   private:
    Points line_;
    mutable std::size_t above_ = 1;  // the corner at or above the last row
  };

  Eigen::Vector2d p_MC_;
  Side left_, right_;
  double reach_;
};

}  // namespace tandem
