// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/ellipse_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tandem {
namespace {

constexpr double kRoom = 1.0 + 1e-9;  // so that rounding leaves no point outside

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Rectangle around points, turned by `angle`.
struct TurnedBox {
  double angle = 0.0;
  Eigen::Vector2d p_MC{0.0, 0.0};
  Eigen::Vector2d half{0.0, 0.0};

  [[nodiscard]] double area() const { return half.x() * half.y(); }
};

TurnedBox box_along(const Points& hull, double angle) {
  const Eigen::Vector2d along{std::cos(angle), std::sin(angle)}, across{-along.y(), along.x()};
  Eigen::Vector2d low{along.dot(hull[0]), across.dot(hull[0])}, high = low;
  for (const auto& p : hull) {
    const Eigen::Vector2d q{along.dot(p), across.dot(p)};
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  const Eigen::Vector2d middle = 0.5 * (low + high);
  return {angle, middle.x() * along + middle.y() * across, 0.5 * (high - low)};
}

// The smallest rectangle; it has a side along an edge of the hull. Its length comes first.
TurnedBox smallest_box(const Points& hull) {
  TurnedBox best;
  best.half.setConstant(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    const TurnedBox box = box_along(hull, std::atan2(edge.y(), edge.x()));
    if (box.area() < best.area() * (1.0 - 1e-9)) best = box;
  }
  if (best.half.x() < best.half.y()) {
    best.angle += 0.5 * std::numbers::pi;
    std::swap(best.half.x(), best.half.y());
  }
  best.angle = std::remainder(best.angle, std::numbers::pi);  // an ellipse looks both ways
  return best;
}

struct Circle {
  Eigen::Vector2d p_MC;
  double radius;

  [[nodiscard]] bool contains(const Eigen::Vector2d& p) const {
    return (p - p_MC).norm() <= kRoom * radius;
  }
};

Circle around(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  return {0.5 * (p + q), 0.5 * (p - q).norm()};
}

// Through three points; around the two farthest apart if they are in line.
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

// Smallest circle around the hull (Welzl 1991, point by point).
Obstacle smallest_circle(const Points& hull) {
  Circle circle{hull[0], 0.0};
  for (std::size_t i = 1; i < hull.size(); ++i) {
    if (circle.contains(hull[i])) continue;
    circle = {hull[i], 0.0};
    for (std::size_t j = 0; j < i; ++j) {
      if (circle.contains(hull[j])) continue;
      circle = around(hull[i], hull[j]);
      for (std::size_t k = 0; k < j; ++k)
        if (!circle.contains(hull[k])) circle = around(hull[i], hull[j], hull[k]);
    }
  }
  Obstacle shape;
  shape.p_MO = circle.p_MC;
  for (const auto& p : hull) shape.a = std::max(shape.a, kRoom * (p - circle.p_MC).norm());
  shape.b = shape.a;
  return shape;
}

// (1), or a circle of radius b if the ellipse would be shorter than wide.
Obstacle ellipse_of_width(const Points& hull, const TurnedBox& box, double b, double shift) {
  Obstacle ellipse;
  ellipse.p_MO = box.p_MC + shift * Eigen::Vector2d{-std::sin(box.angle), std::cos(box.angle)};
  ellipse.angle = box.angle;
  for (const auto& p : hull) {
    const Eigen::Vector2d q = in_axes(ellipse, p);
    const double s = q.y() / b;
    ellipse.a = std::max(ellipse.a, std::abs(q.x()) / std::sqrt(1.0 - s * s));
  }
  ellipse.a = kRoom * std::max(ellipse.a, b);
  ellipse.b = kRoom * b;
  return ellipse;
}

// Whether every point along an ellipse with the shape's centre and heading is allowed.
bool is_within_along(const Obstacle& shape, const Eigen::Vector2d& half, const FreeSpace& space,
                     double most) {
  constexpr double kSpacing = 0.04;  // [m]
  const double c = std::cos(shape.angle), s = std::sin(shape.angle);
  const int points = std::max(16, static_cast<int>(4.0 * half.sum() / kSpacing));
  const double step = 2.0 * std::numbers::pi / points;
  const double cos_step = std::cos(step), sin_step = std::sin(step);
  double x = 1.0, y = 0.0;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector2d q{half.x() * x, half.y() * y};
    const Eigen::Vector2d turned_q{c * q.x() - s * q.y(), s * q.x() + c * q.y()};
    if (!space.allows(shape.p_MO + turned_q, most)) return false;
    const double turned = cos_step * x - sin_step * y;
    y = sin_step * x + cos_step * y;
    x = turned;
  }
  return true;
}

// Whether the shape reaches no deeper into free space than `most`: its outline, smaller copies
// inside, and its long axis, where those are far apart. False if it leaves the known window.
bool is_within(const Obstacle& shape, const FreeSpace& space, double most) {
  constexpr double kRing = 0.07;  // [m] between two copies, across
  const double c = std::cos(shape.angle), s = std::sin(shape.angle);
  const Eigen::Vector2d reach{std::hypot(c * shape.a, s * shape.b),
                              std::hypot(s * shape.a, c * shape.b)};
  if (!space.knows(shape.p_MO - reach, shape.p_MO + reach)) return false;
  const Eigen::Vector2d half{shape.a, shape.b};
  const int rings = std::max(1, static_cast<int>(std::ceil(shape.b / kRing)));
  for (int ring = rings; ring > 0; --ring)
    if (!is_within_along(shape, half * ring / rings, space, most)) return false;
  return is_within_along(shape, {shape.a, 0.0}, space, most);
}

}  // namespace

Points convex_hull(Points points) {
  std::sort(points.begin(), points.end(), [](const auto& p, const auto& q) {
    return p.y() != q.y() ? p.y() < q.y() : p.x() < q.x();
  });
  Points hull;  // Andrew's monotone chain: the right side going up, then the left coming down
  const auto add = [&hull](const Eigen::Vector2d& p, std::size_t fixed) {
    while (hull.size() >= fixed + 2 &&
           cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 1e-12)
      hull.pop_back();
    hull.push_back(p);
  };
  for (const auto& p : points) add(p, 0);
  const std::size_t top = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, top);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

EllipseFit fit_ellipse(const Points& hull, const FreeSpace& space, const FitLimits& limits) {
  const TurnedBox box = smallest_box(hull);
  struct Candidate {
    Obstacle shape;
    double price;
  };
  const auto price = [&](const Obstacle& shape) {
    return space.taken_by(shape) - (shape.a == shape.b ? limits.circle_bonus : 0.0);
  };
  std::vector<Candidate> candidates;
  const auto add = [&](const Obstacle& shape) {
    if (const double paid = price(shape); paid <= limits.price) candidates.push_back({shape, paid});
  };
  const Obstacle circle = smallest_circle(hull);
  add(circle);
  const double h = box.half.y();
  for (const double shift : {0.0, 1.0, -1.0, 3.0, -3.0})
    for (const double bulge : {0.01, 0.02, 0.03, 0.045, 0.07, 0.11, 0.16, 0.23})
      add(ellipse_of_width(hull, box, h + std::abs(shift * bulge) + bulge, shift * bulge));
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.price < b.price; });
  for (const auto& [shape, paid] : candidates)
    if (is_within(shape, space, limits.excess)) return {shape, paid, true, box.angle};
  return {circle, price(circle), false, box.angle};
}

}  // namespace tandem
