// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/footprint.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

namespace tandem {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Box {
  explicit Box(const ConvexPolygon& polygon) : low{polygon.front()}, high{polygon.front()} {
    for (const auto& p : polygon) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  Eigen::Vector2d low, high;
};

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

bool contains(const ConvexPolygon& polygon, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& a = polygon[i];
    const auto& b = polygon[(i + 1) % polygon.size()];
    if (cross(b - a, p - a) < 0.0) return false;
  }
  return true;
}

// Squared distance from a convex polygon to a point, 0 inside. Only edges that have the point on
// their outer side are measured: one of them is the nearest.
double squared_distance_to_point(const ConvexPolygon& polygon, const Eigen::Vector2d& p) {
  double d2 = kInfinity;
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

// The part of the polygon at least `depth` to the left of the line through a along the unit vector.
ConvexPolygon clip(const ConvexPolygon& polygon, const Eigen::Vector2d& a,
                   const Eigen::Vector2d& along, double depth) {
  ConvexPolygon left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& p = polygon[i];
    const Eigen::Vector2d& q = polygon[(i + 1) % polygon.size()];
    const double p_in = cross(along, p - a) - depth, q_in = cross(along, q - a) - depth;
    if (p_in >= 0.0) left.push_back(p);
    if (p_in * q_in < 0.0) left.emplace_back(p + p_in / (p_in - q_in) * (q - p));
  }
  return left;
}

// Whether the polygon, counter-clockwise, overlaps the square |x|, |y| ≤ 1.
bool overlaps_unit_square(const ConvexPolygon& polygon) {
  const Box box(polygon);
  if (!((box.low.array() < 1.0).all() && (box.high.array() > -1.0).all())) return false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& p = polygon[i];
    const Eigen::Vector2d edge = polygon[(i + 1) % polygon.size()] - p;
    // Times the edge's length, the square's centre lies −edge × p to the left of the edge, and the
    // corner farthest to the left |edge|₁ more.
    const double reach = edge.lpNorm<1>();
    if (reach > 0.0 && reach <= cross(edge, p)) return false;
  }
  return true;
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

[[noreturn]] void refuse(const std::string& where, const std::string& why) {
  throw std::invalid_argument("footprint: " + where + ": " + why);
}

// `part` and `vertex` are counted from 0 here and from 1 in the text.
std::string place(std::size_t part, std::size_t vertex, const Eigen::Vector2d& p_BV) {
  std::ostringstream text;
  text << "part " << part + 1 << ", vertex " << vertex + 1 << " at (" << p_BV.x() << ", "
       << p_BV.y() << ")";
  return text.str();
}

// The fault of the corner b between its neighbours a and c; empty if there is none.
std::string fault(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const double turn = cross(b - a, c - b);
  if (a == b) return "repeats the vertex before it; give each vertex once, the first not again";
  if (turn < 0.0)
    return "the outline turns right; list the vertices counter-clockwise, and split a concave "
           "outline into convex parts (footprint_parts)";
  if (!(turn > 0.0) && b != c) return "is collinear with its neighbours; remove it";
  return "";
}

// Left turns alone do not make a polygon convex: those of a pentagram add up to two full turns.
void check_part(const ConvexPolygon& part, std::size_t index) {
  const std::size_t size = part.size();
  if (size < 3)
    refuse("part " + std::to_string(index + 1),
           "has " + std::to_string(size) + " vertices; a polygon needs at least 3");
  for (std::size_t i = 0; i < size; ++i)
    if (!part[i].allFinite()) refuse(place(index, i, part[i]), "is not a pair of finite numbers");
  double turned = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const auto &a = part[(i + size - 1) % size], &b = part[i], &c = part[(i + 1) % size];
    const std::string why = fault(a, b, c);
    if (!why.empty()) refuse(place(index, i, b), why);
    turned += std::atan2(cross(b - a, c - b), (b - a).dot(c - b));
    if (!(turned < 2.0 * std::numbers::pi + 1e-6))
      refuse(place(index, i, b),
             "up to here the outline turns by more than 360°, so it crosses itself; list each "
             "vertex once");
  }
}

void check_origin(const std::vector<ConvexPolygon>& parts) {
  const auto has_origin = [](const ConvexPolygon& part) {
    return contains(part, Eigen::Vector2d::Zero());
  };
  if (std::any_of(parts.begin(), parts.end(), has_origin)) return;
  const auto nearest =
      std::min_element(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
        return distance(a, {0.0, 0.0}) < distance(b, {0.0, 0.0});
      });
  std::ostringstream text;
  text << "footprint: no part contains (0, 0), the origin of base_link; the nearest, part "
       << nearest - parts.begin() + 1 << ", is " << distance(*nearest, {0.0, 0.0})
       << " m away. Give the vertices in the frame base_link; one part must contain its origin";
  throw std::invalid_argument(text.str());
}

// Covers one part by slices of its bounding box along `axis` (0: x, 1: y).
std::vector<Disc> cover_part(const ConvexPolygon& part, Eigen::Index axis, double overhang) {
  const Box box(part);
  const Eigen::Index across = 1 - axis;
  const double half_length = 0.5 * (box.high[axis] - box.low[axis]);
  const double half_width = 0.5 * (box.high[across] - box.low[across]);
  const double longest = std::sqrt(overhang * (overhang + 2.0 * half_width));  // half a slice
  const int count = std::max(1, static_cast<int>(std::ceil(half_length / longest - 1e-9)));
  const double half_slice = half_length / count;
  std::vector<Disc> discs;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector2d p_BC;
    p_BC[axis] = box.low[axis] + (2 * i + 1) * half_slice;
    p_BC[across] = 0.5 * (box.low[across] + box.high[across]);
    discs.push_back({p_BC, std::hypot(half_slice, half_width)});
  }
  return discs;
}

}  // namespace

Footprint rectangle(double length, double width, double center_x) {
  const double l = 0.5 * length, w = 0.5 * width;
  return polygon({{center_x - l, -w}, {center_x + l, -w}, {center_x + l, w}, {center_x - l, w}});
}

Footprint polygons(std::vector<ConvexPolygon> parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) check_part(parts[i], i);
  if (parts.empty()) throw std::invalid_argument("footprint: has no parts");
  check_origin(parts);
  return {std::move(parts)};
}

Footprint polygon(ConvexPolygon p_BV) { return polygons({std::move(p_BV)}); }

double circumradius(const Footprint& footprint) {
  double radius = 0.0;
  for (const auto& part : footprint.parts)
    for (const auto& p : part) radius = std::max(radius, p.norm());
  return radius;
}

Extent extent(const Footprint& footprint) {
  Extent e;
  for (const auto& part : footprint.parts)
    for (const auto& p_BV : part) {
      e.front = std::max(e.front, p_BV.x());
      e.rear = std::max(e.rear, -p_BV.x());
      e.left = std::max(e.left, p_BV.y());
      e.right = std::max(e.right, -p_BV.y());
    }
  return e;
}

double width(const Footprint& footprint) {
  double low = kInfinity, high = -kInfinity;
  for (const auto& part : footprint.parts) {
    for (const auto& p : part) {
      low = std::min(low, p.y());
      high = std::max(high, p.y());
    }
  }
  return high - low;
}

double distance(const ConvexPolygon& part, const Eigen::Vector2d& p_BQ) {
  return std::sqrt(squared_distance_to_point(part, p_BQ));
}

double distance(const Footprint& footprint, const Eigen::Vector2d& p_BQ) {
  double d = kInfinity;
  for (const auto& part : footprint.parts) d = std::min(d, distance(part, p_BQ));
  return d;
}

double distance_to_square(const ConvexPolygon& part, const Pose2& X_MB, const Eigen::Vector2d& p_MC,
                          double side) {
  const double half = 0.5 * side;
  const double c = std::cos(X_MB.theta), s = std::sin(X_MB.theta);
  const Eigen::Vector2d p_CB{X_MB.x - p_MC.x(), X_MB.y - p_MC.y()};
  const auto in_square_axes = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return {p_CB.x() + c * p.x() - s * p.y(), p_CB.y() + s * p.x() + c * p.y()};
  };
  double d2 = kInfinity;
  Eigen::Vector2d a = in_square_axes(part.back());
  for (const auto& p_BV : part) {
    const Eigen::Vector2d b = in_square_axes(p_BV);
    if (crosses_square(a, b, half)) return 0.0;
    d2 = std::min(d2, squared_distance_to_square(b, half));
    a = b;
  }
  // No edge meets the square: it is either apart or wholly inside. The corners decide.
  for (const double x : {-half, half})
    for (const double y : {-half, half}) {
      const Eigen::Vector2d q{x - p_CB.x(), y - p_CB.y()};
      d2 = std::min(
          d2, squared_distance_to_point(part, {c * q.x() + s * q.y(), -s * q.x() + c * q.y()}));
    }
  return std::sqrt(d2);
}

double distance_to_square(const Footprint& footprint, const Pose2& X_MB,
                          const Eigen::Vector2d& p_MC, double side) {
  double d = kInfinity;
  for (const auto& part : footprint.parts)
    d = std::min(d, distance_to_square(part, X_MB, p_MC, side));
  return d;
}

Footprint inset(const Footprint& footprint, double depth) {
  Footprint result;
  for (const auto& part : footprint.parts) {
    ConvexPolygon left = part;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Eigen::Vector2d edge = part[(i + 1) % part.size()] - part[i];
      left = clip(left, part[i], edge.normalized(), depth);
    }
    if (!left.empty()) result.parts.push_back(std::move(left));
  }
  return result;
}

bool overlaps(const Footprint& footprint, const Pose2& X_MB, const Obstacle& obstacle) {
  // The pose of the body in the obstacle's axes.
  const Eigen::Vector2d p = in_axes(obstacle, X_MB.position());
  const double c = std::cos(X_MB.theta - obstacle.angle);
  const double s = std::sin(X_MB.theta - obstacle.angle);
  ConvexPolygon image;  // the obstacle becomes the unit disc or the square |x|, |y| ≤ 1
  const auto touches = [&](const ConvexPolygon& part) {
    image.clear();
    image.reserve(part.size());
    for (const auto& p_BV : part)
      image.emplace_back((p.x() + c * p_BV.x() - s * p_BV.y()) / obstacle.a,
                         (p.y() + s * p_BV.x() + c * p_BV.y()) / obstacle.b);
    if (is_rectangle(obstacle)) return overlaps_unit_square(image);
    return squared_distance_to_point(image, Eigen::Vector2d::Zero()) < 1.0;
  };
  return std::any_of(footprint.parts.begin(), footprint.parts.end(), touches);
}

std::vector<Disc> cover_by_discs(const Footprint& footprint, double overhang) {
  std::vector<Disc> discs;
  for (const auto& part : footprint.parts) {
    const Box box(part);
    const Eigen::Vector2d size = box.high - box.low;
    const bool is_wide = footprint.parts.size() > 1 && size.y() > size.x();
    const auto cover = cover_part(part, is_wide ? 1 : 0, overhang);
    discs.insert(discs.end(), cover.begin(), cover.end());
  }
  return discs;
}

}  // namespace tandem
