// SPDX-License-Identifier: Apache-2.0
#include "model/footprint.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace tandem {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double squared_distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                                   const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a, ap = p - a;
  const double length2 = ab.squaredNorm(), along = ap.dot(ab);
  if (along <= 0.0 || length2 <= 0.0) return ap.squaredNorm();
  if (along >= length2) return (p - b).squaredNorm();
  return (ap - along / length2 * ab).squaredNorm();
}

bool contains(const Polygon& polygon, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& a = polygon[i];
    const auto& b = polygon[(i + 1) % polygon.size()];
    if (cross(b - a, p - a) < 0.0) return false;
  }
  return true;
}

// From a convex polygon to a point, 0 inside. Only the edges that the point lies outside of are
// measured: one of them is the nearest.
double squared_distance_to_point(const Polygon& polygon, const Eigen::Vector2d& p) {
  double d2 = std::numeric_limits<double>::infinity();
  bool inside = true;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& a = polygon[i];
    const auto& b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    if (cross(b - a, p - a) >= 0.0) continue;
    inside = false;
    d2 = std::min(d2, squared_distance_to_segment(p, a, b));
  }
  return inside ? 0.0 : d2;
}

double squared_distance_to_square(const Eigen::Vector2d& p, double half) {
  const double dx = std::max(0.0, std::abs(p.x()) - half);
  const double dy = std::max(0.0, std::abs(p.y()) - half);
  return dx * dx + dy * dy;
}

// Whether segment ab meets the square |x|, |y| ≤ half (slab clipping).
bool crosses_square(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double half) {
  if (std::min(a.x(), b.x()) > half || std::max(a.x(), b.x()) < -half ||
      std::min(a.y(), b.y()) > half || std::max(a.y(), b.y()) < -half)
    return false;
  double t0 = 0.0, t1 = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    const double origin = a[axis], direction = b[axis] - a[axis];
    if (direction == 0.0) {
      if (std::abs(origin) > half) return false;
      continue;
    }
    const double u = (-half - origin) / direction, v = (half - origin) / direction;
    t0 = std::max(t0, std::min(u, v));
    t1 = std::min(t1, std::max(u, v));
  }
  return t0 <= t1;
}

}  // namespace

Footprint rectangle(double length, double width, double center_x) {
  const double l = 0.5 * length, w = 0.5 * width;
  return polygon({{center_x - l, -w}, {center_x + l, -w}, {center_x + l, w}, {center_x - l, w}});
}

Footprint polygon(std::vector<Eigen::Vector2d> p_BV) {
  if (p_BV.size() < 3) throw std::invalid_argument("footprint: fewer than 3 vertices");
  for (std::size_t i = 0; i < p_BV.size(); ++i) {
    const auto& a = p_BV[i];
    const auto& b = p_BV[(i + 1) % p_BV.size()];
    const auto& c = p_BV[(i + 2) % p_BV.size()];
    if (!a.allFinite() || !(cross(b - a, c - b) > 0.0))
      throw std::invalid_argument(
          "footprint: vertices must be finite, convex and counter-clockwise, without repeats");
  }
  if (!contains(p_BV, Eigen::Vector2d::Zero()))
    throw std::invalid_argument("footprint: must contain the origin of base_link");
  return {std::move(p_BV)};
}

double circumradius(const Footprint& footprint) {
  double radius = 0.0;
  for (const auto& p : footprint.p_BV) radius = std::max(radius, p.norm());
  return radius;
}

double distance(const Footprint& footprint, const Eigen::Vector2d& p_BQ) {
  return std::sqrt(squared_distance_to_point(footprint.p_BV, p_BQ));
}

double distance_to_square(const Footprint& footprint, const Pose2& X_MB,
                          const Eigen::Vector2d& p_MC, double side) {
  const double half = 0.5 * side;
  const double c = std::cos(X_MB.theta), s = std::sin(X_MB.theta);
  const Eigen::Vector2d p_CB{X_MB.x - p_MC.x(), X_MB.y - p_MC.y()};
  const auto in_square_axes = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return {p_CB.x() + c * p.x() - s * p.y(), p_CB.y() + s * p.x() + c * p.y()};
  };
  double d2 = std::numeric_limits<double>::infinity();
  Eigen::Vector2d a = in_square_axes(footprint.p_BV.back());
  for (const auto& p_BV : footprint.p_BV) {
    const Eigen::Vector2d b = in_square_axes(p_BV);
    if (crosses_square(a, b, half)) return 0.0;
    d2 = std::min(d2, squared_distance_to_square(b, half));
    a = b;
  }
  // No edge meets the square: apart, or the square lies wholly inside. Corners settle both.
  for (const double x : {-half, half})
    for (const double y : {-half, half}) {
      const Eigen::Vector2d q{x - p_CB.x(), y - p_CB.y()};
      d2 = std::min(d2, squared_distance_to_point(footprint.p_BV,
                                                  {c * q.x() + s * q.y(), -s * q.x() + c * q.y()}));
    }
  return std::sqrt(d2);
}

bool overlaps(const Footprint& footprint, const Pose2& X_MB, const Obstacle& obstacle) {
  Polygon outline;
  outline.reserve(footprint.p_BV.size());
  for (const auto& p_BV : footprint.p_BV) {
    const Eigen::Vector2d q = in_axes(obstacle, transform(X_MB, p_BV));
    outline.emplace_back(q.x() / obstacle.a, q.y() / obstacle.b);
  }
  return squared_distance_to_point(outline, Eigen::Vector2d::Zero()) < 1.0;
}

std::vector<Disc> cover_by_discs(const Footprint& footprint, double overhang) {
  Eigen::Vector2d low = footprint.p_BV.front(), high = low;
  for (const auto& p : footprint.p_BV) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double half_length = 0.5 * (high.x() - low.x()), half_width = 0.5 * (high.y() - low.y());
  const double longest = std::sqrt(overhang * (overhang + 2.0 * half_width));  // half a slice
  const int count = std::max(1, static_cast<int>(std::ceil(half_length / longest - 1e-9)));
  const double half_slice = half_length / count;
  std::vector<Disc> discs;
  for (int i = 0; i < count; ++i)
    discs.push_back({{low.x() + (2 * i + 1) * half_slice, 0.5 * (low.y() + high.y())},
                     std::hypot(half_slice, half_width)});
  return discs;
}

}  // namespace tandem
