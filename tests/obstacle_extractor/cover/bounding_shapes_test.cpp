// SPDX-License-Identifier: Apache-2.0
// Bounding shapes of random points, against searches that try everything.
#include "tandem/obstacle_extractor/cover/bounding_shapes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace tandem {
namespace {

constexpr double kRounding = 1e-9;  // [m]

// From one point to a cloud; some clouds lie on a line or on the corners of a grid.
Points random_points(unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> coordinate{-2.0, 2.0};
  Points points(1 + random() % 12);
  for (auto& p : points) p = {coordinate(random), coordinate(random)};
  if (seed % 5 == 1)
    for (auto& p : points) p.y() = 0.5 * p.x() - 0.3;
  if (seed % 5 == 2)
    for (auto& p : points) p = {0.5 * std::round(2.0 * p.x()), 0.5 * std::round(2.0 * p.y())};
  return points;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

template <class Visit>  // (seed, points, hull)
void for_random_points(Visit&& visit) {
  for (unsigned seed = 0; seed < 2000; ++seed) {
    const Points points = random_points(seed);
    visit(seed, points, convex_hull(points));
  }
}

TEST(BoundingShapes, TheHullIsConvexAndItsCornersArePoints) {
  for_random_points([](unsigned seed, const Points& points, const Points& hull) {
    ASSERT_FALSE(hull.empty()) << seed;
    for (const auto& corner : hull)
      EXPECT_NE(std::find(points.begin(), points.end(), corner), points.end()) << seed;
    const std::size_t n = hull.size();
    if (n < 3) return;
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d edge = hull[(i + 1) % n] - hull[i];
      EXPECT_GT(cross(edge, hull[(i + 2) % n] - hull[i]), 0.0) << "a left turn, " << seed;
      for (const auto& p : points) EXPECT_GE(cross(edge, p - hull[i]), -kRounding) << seed;
    }
  });
}

bool contains(const Circle& circle, const Points& points) {
  return std::all_of(points.begin(), points.end(), [&](const auto& p) {
    return (p - circle.p_MC).norm() <= circle.radius + kRounding;
  });
}

// Of all circles through two points as a diameter, or through three.
double smallest_radius(const Points& points) {
  double least = std::numeric_limits<double>::infinity();
  const auto try_circle = [&](const Circle& circle) {
    if (circle.radius < least && contains(circle, points)) least = circle.radius;
  };
  for (const auto& p : points) {
    try_circle({p, 0.0});
    for (const auto& q : points) {
      try_circle({0.5 * (p + q), 0.5 * (p - q).norm()});
      for (const auto& r : points) {
        const Eigen::Vector2d a = q - p, b = r - p;
        const double area = 2.0 * cross(a, b);
        if (std::abs(area) < kRounding) continue;
        const Eigen::Vector2d c{(b.y() * a.squaredNorm() - a.y() * b.squaredNorm()) / area,
                                (a.x() * b.squaredNorm() - b.x() * a.squaredNorm()) / area};
        try_circle({p + c, c.norm()});
      }
    }
  }
  return least;
}

TEST(BoundingShapes, NoCircleAroundThePointsIsSmaller) {
  for_random_points([](unsigned seed, const Points& points, const Points& hull) {
    const Circle circle = smallest_circle(hull);
    EXPECT_TRUE(contains(circle, points)) << seed;
    EXPECT_NEAR(circle.radius, smallest_radius(points), 1e-7) << seed;
  });
}

// Half sides of the box around the points at that angle.
Eigen::Vector2d half_sides(const Points& points, double angle) {
  const Eigen::Vector2d along{std::cos(angle), std::sin(angle)}, across{-along.y(), along.x()};
  Eigen::Vector2d half;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d& unit = axis == 0 ? along : across;
    const auto [low, high] = std::minmax_element(
        points.begin(), points.end(),
        [&](const auto& p, const auto& q) { return unit.dot(p) < unit.dot(q); });
    half[axis] = 0.5 * unit.dot(*high - *low);
  }
  return half;
}

TEST(BoundingShapes, NoBoxAroundThePointsIsSmallerAndTheLongSideComesFirst) {
  for_random_points([](unsigned seed, const Points& points, const Points& hull) {
    const TurnedBox box = smallest_box(hull);
    EXPECT_GE(box.half.x(), box.half.y()) << seed;
    EXPECT_NEAR((half_sides(points, box.angle) - box.half).norm(), 0.0, kRounding) << seed;
    for (double angle = 0.0; angle < 0.5 * std::numbers::pi; angle += 0.01)
      EXPECT_LE(box.area(), half_sides(points, angle).prod() + kRounding) << seed;
  });
}

TEST(BoundingShapes, ABoxLiesAroundItsCentre) {
  for_random_points([](unsigned seed, const Points& points, const Points& hull) {
    const TurnedBox box = box_along(hull, 0.1 * seed);
    const Eigen::Rotation2Dd R_BM{-box.angle};
    for (const auto& p : points) {
      const Eigen::Vector2d p_BQ = R_BM * (p - box.p_MC);
      EXPECT_LE(std::abs(p_BQ.x()), box.half.x() + kRounding) << seed;
      EXPECT_LE(std::abs(p_BQ.y()), box.half.y() + kRounding) << seed;
    }
  });
}

}  // namespace
}  // namespace tandem
