// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/dilated_shape.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <utility>

#include "tandem/local_planner/ocp/signed_distance.hpp"

namespace tandem::test {
namespace {

constexpr double kRadius = 0.3, kStep = 0.02;

Obstacle random_shape(std::mt19937& random, ObstacleShape shape) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double b = 0.02 + 0.5 * unit(random), a = b + 1.5 * unit(random);
  return {.p_MO = {unit(random), unit(random)},
          .a = a,
          .b = b,
          .angle = 6.3 * unit(random),
          .shape = shape};
}

// How far the point is from the shape, where the row's `x` and `y` are relative to its centre.
double distance_at(const Obstacle& shape, double x, double y) {
  return signed_distance(shape, shape.p_MO + kStep * Eigen::Vector2d{x, y}).value;
}

// A row may end this far inside the dilated shape, never outside it.
template <class Dilated>
void expect_rows_end_at_the_disc(ObstacleShape kind, double most_short) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    const Obstacle shape = random_shape(random, kind);
    const Dilated all{shape, {std::cos(shape.angle), std::sin(shape.angle)}, kRadius, kStep};
    EXPECT_GT(all.row(1.01 * all.reach()).left, all.row(1.01 * all.reach()).right);
    for (double y = -0.95; y < 1.0; y += 0.1) {
      const RowExtent row = all.row(y * all.reach());
      ASSERT_LT(row.left, row.right);
      for (const double x : {row.left, row.right}) {
        const double distance = distance_at(shape, x, y * all.reach());
        EXPECT_LE(distance, kRadius + 1e-9);
        EXPECT_GE(distance, kRadius - most_short);
      }
    }
  }
}

TEST(DilatedEllipse, RowsEndWhereTheDiscStopsTouching) {
  expect_rows_end_at_the_disc<DilatedEllipse>(ObstacleShape::kEllipse, kRadius);
}

TEST(DilatedRectangle, RowsEndWhereTheDiscStopsTouching) {
  expect_rows_end_at_the_disc<DilatedRectangle>(ObstacleShape::kRectangle, 0.08 * kRadius);
}

TEST(DilatedHull, RowsEndWhereTheDiscStopsTouching) {
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) {
    const Obstacle shape = random_shape(random, ObstacleShape::kRectangle);
    Points corners;
    for (const auto& [x, y] : {std::pair{1.0, 1.0}, {-1.0, 1.0}, {-1.0, -1.0}, {1.0, -1.0}})
      corners.push_back(shape.p_MO + Eigen::Rotation2Dd(shape.angle) *
                                         Eigen::Vector2d{x * shape.a, y * shape.b});
    const DilatedHull hull(convex_hull(corners), kRadius, kStep);
    EXPECT_GT(hull.row(1.01 * hull.reach()).left, hull.row(1.01 * hull.reach()).right);
    for (double y = -0.95; y < 1.0; y += 0.1) {
      const RowExtent row = hull.row(y * hull.reach());
      ASSERT_LT(row.left, row.right);
      for (const double x : {row.left, row.right}) {
        const Eigen::Vector2d p = hull.p_MC() + kStep * Eigen::Vector2d{x, y * hull.reach()};
        const double distance = signed_distance(shape, p).value;
        EXPECT_LE(distance, kRadius + 1e-9);
        EXPECT_GE(distance, 0.92 * kRadius);
      }
    }
  }
}

}  // namespace
}  // namespace tandem::test
