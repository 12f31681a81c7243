// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/bounding_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tandem {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool is_inside(const Circle& circle, const Eigen::Vector2d& p) {
  return (p - circle.p_MC).norm() <= (1.0 + 1e-9) * circle.radius;
}

Circle around(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  return {0.5 * (p + q), 0.5 * (p - q).norm()};
}

// Circle through three points; if they are collinear, around the two farthest apart.
Circle around(const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& r) {
  const Eigen::Vector2d u = q - p, v = r - p;
  const double twice_area = 2.0 * cross(u, v);
  if (std::abs(twice_area) < 1e-12) {
    const std::array pairs{around(p, q), around(p, r), around(q, r)};
    return *std::max_element(pairs.begin(), pairs.end(),
                             [](const auto& a, const auto& b) { return a.radius < b.radius; });
  }
  const Eigen::Vector2d d{(v.y() * u.squaredNorm() - u.y() * v.squaredNorm()) / twice_area,
                          (u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) / twice_area};
  return {p + d, d.norm()};
}

// The rectangle with a side along this unit vector, without its angle.
TurnedBox box_beside(const Points& hull, const Eigen::Vector2d& along) {
  const Eigen::Vector2d across{-along.y(), along.x()};
  Eigen::Vector2d low{along.dot(hull[0]), across.dot(hull[0])}, high = low;
  for (const auto& p : hull) {
    const Eigen::Vector2d q{along.dot(p), across.dot(p)};
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  const Eigen::Vector2d middle = 0.5 * (low + high);
  return {0.0, along, middle.x() * along + middle.y() * across, 0.5 * (high - low)};
}

}  // namespace

TurnedBox box_along(const Points& hull, double angle) {
  TurnedBox box = box_beside(hull, {std::cos(angle), std::sin(angle)});
  box.angle = angle;
  return box;
}

TurnedBox smallest_box(const Points& hull) {
  TurnedBox best;
  best.half.setConstant(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = hull[i + 1 < hull.size() ? i + 1 : 0] - hull[i];
    const TurnedBox box = box_beside(hull, edge.normalized());
    if (box.area() < best.area() * (1.0 - 1e-9)) best = box;
  }
  if (best.half.x() < best.half.y()) {
    best.along = {-best.along.y(), best.along.x()};
    std::swap(best.half.x(), best.half.y());
  }
  if (best.along.x() < 0.0) best.along = -best.along;  // symmetric under half a turn
  best.angle = std::atan2(best.along.y(), best.along.x());
  return best;
}

Circle smallest_circle(const Points& hull) {
  Circle circle{hull[0], 0.0};
  for (std::size_t i = 1; i < hull.size(); ++i) {
    if (is_inside(circle, hull[i])) continue;
    circle = {hull[i], 0.0};
    for (std::size_t j = 0; j < i; ++j) {
      if (is_inside(circle, hull[j])) continue;
      circle = around(hull[i], hull[j]);
      for (std::size_t k = 0; k < j; ++k)
        if (!is_inside(circle, hull[k])) circle = around(hull[i], hull[j], hull[k]);
    }
  }
  return circle;
}

}  // namespace tandem
