// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. The places at which a disc touches a shape, row by row.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/bounding_shapes.hpp"

namespace tandem {

/// Interval of x; empty if left > right.
struct RowExtent {
  double left, right;
};

/// An ellipse of which the dilated ellipse is a superset: its axes are longer by the disc's radius
/// (the support function of the sum is larger).
class DilatedEllipse {
 public:
  DilatedEllipse(const Obstacle& shape, double radius, double step);

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
  DilatedRectangle(const Obstacle& shape, double radius, double step);

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
  [[nodiscard]] RowExtent row(double y) const;

 private:
  Eigen::Vector2d p_MC_;
  std::vector<Eigen::Vector2d> left_, right_;  // its sides, upwards
  double reach_;
};

/// The shape dilated by a disc of `radius` [m], about its centre, in units of `step` [m]: the
/// centres of the discs that touch the shape. Slightly too small, which is accurate enough for a
/// cost. `reach()` is its largest |y|, `row(y)` its extent in x at height y.
[[nodiscard]] std::variant<DilatedEllipse, DilatedRectangle> dilated(const Obstacle& shape,
                                                                     double radius, double step);

}  // namespace tandem
