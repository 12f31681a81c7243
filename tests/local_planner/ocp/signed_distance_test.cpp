// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/signed_distance.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "support/level.hpp"

namespace tandem {
namespace {

using test::level;

struct Case {
  Obstacle obstacle;
  Eigen::Vector2d p_MQ;
};

// Walls (thin, metres long), poles and everything between, ellipses and rectangles, with points
// inside and outside.
Case random_case(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double b = std::pow(10.0, -1.5 + 1.2 * std::abs(unit(random)));
  const double a = b * std::pow(10.0, 1.5 * std::abs(unit(random)));
  const auto shape = unit(random) > 0.0 ? ObstacleShape::kEllipse : ObstacleShape::kRectangle;
  return {{1, {unit(random), unit(random)}, a, b, 4.0 * unit(random), {0, 0}, shape},
          {(a + 1.5) * unit(random), (a + 1.5) * unit(random)}};
}

// A point of the outline; s from 0 to 2π goes round it once.
Eigen::Vector2d outline(const Obstacle& obstacle, double s) {
  if (!is_rectangle(obstacle)) return {obstacle.a * std::cos(s), obstacle.b * std::sin(s)};
  const double turns = 2.0 * s / std::numbers::pi, along = 2.0 * (turns - std::floor(turns)) - 1.0;
  const int side = static_cast<int>(std::floor(turns)) & 3;
  const double sign = side < 2 ? 1.0 : -1.0;
  if (side % 2 == 0) return {sign * obstacle.a, sign * obstacle.b * along};
  return {-sign * obstacle.a * along, sign * obstacle.b};
}

double brute_force(const Obstacle& obstacle, const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d q = in_axes(obstacle, p_MQ);
  const auto distance_at = [&](double s) { return (q - outline(obstacle, s)).norm(); };
  constexpr int kSamples = 20000;
  const double step = 2.0 * std::numbers::pi / kSamples;
  double best = 0.0;
  for (int i = 1; i < kSamples; ++i)
    if (distance_at(i * step) < distance_at(best)) best = i * step;
  for (double h = step; h > 1e-12; h *= 0.5)
    for (const double s : {best - h, best + h})
      if (distance_at(s) < distance_at(best)) best = s;
  return level(obstacle, p_MQ) < 1.0 ? -distance_at(best) : distance_at(best);
}

TEST(SignedDistance, EqualsTheDistanceToADenselySampledOutline) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    const Case c = random_case(random);
    EXPECT_NEAR(signed_distance(c.obstacle, c.p_MQ).value, brute_force(c.obstacle, c.p_MQ), 1e-7)
        << "a " << c.obstacle.a << " b " << c.obstacle.b;
  }
}

TEST(SignedDistance, IsExactOnAxesCentreAndCircleAndInEachRegionOfARectangle) {
  const Obstacle wall{1, {0, 0}, 2.0, 0.1, 0.0, {0, 0}}, pole{2, {1, 2}, 0.3, 0.3, 0.7, {0, 0}};
  EXPECT_NEAR(signed_distance(wall, {2.5, 0.0}).value, 0.5, 1e-9);
  EXPECT_NEAR(signed_distance(wall, {0.0, -0.4}).value, 0.3, 1e-9);
  EXPECT_NEAR(signed_distance(wall, {0.0, 0.0}).value, -0.1, 1e-9);
  EXPECT_NEAR(signed_distance(wall, {1.0, 0.0}).value, -0.1 * std::sqrt(1.0 - 1.0 / 3.99), 1e-9);
  EXPECT_NEAR(signed_distance(pole, {1.0, 2.0}).value, -0.3, 1e-9);
  EXPECT_NEAR(signed_distance(pole, {4.0, 6.0}).value, 4.7, 1e-9);
  Obstacle bed = wall;
  bed.shape = ObstacleShape::kRectangle;
  EXPECT_NEAR(signed_distance(bed, {1.0, -0.4}).value, 0.3, 1e-12);
  EXPECT_EQ(signed_distance(bed, {1.0, -0.4}).curvature, 0.0);
  EXPECT_NEAR(signed_distance(bed, {-2.3, 0.5}).value, 0.5, 1e-12);
  EXPECT_NEAR(signed_distance(bed, {-2.3, 0.5}).curvature, 2.0, 1e-12);
  EXPECT_NEAR(signed_distance(bed, {2.0 + 1e-4, 0.1 + 1e-4}).curvature, 20.0, 1e-12);
  EXPECT_NEAR(signed_distance(bed, {1.0, 0.08}).value, -0.02, 1e-12);
  EXPECT_NEAR(signed_distance(bed, {-1.99, 0.0}).value, -0.01, 1e-12);
}

// The sum of obstacle and disc: a disc of the distance's radius touches the outline, none larger
// stays clear of it. So {value > r} neither hides a contact nor forbids a free place.
TEST(SignedDistance, BoundsTheInflatedObstacleConservativelyAndTightly) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
  for (int i = 0; i < 2000; ++i) {
    const Case c = random_case(random);
    const SignedDistance d = signed_distance(c.obstacle, c.p_MQ);
    if (d.value <= 1e-6) continue;
    const Eigen::Vector2d touching = c.p_MQ - (d.value + 1e-6) * d.normal;
    EXPECT_LT(level(c.obstacle, touching), 1.0);
    for (int k = 0; k < 50; ++k) {
      const double s = angle(random);
      const Eigen::Vector2d rim =
          c.p_MQ + (d.value - 1e-6) * Eigen::Vector2d{std::cos(s), std::sin(s)};
      EXPECT_GT(level(c.obstacle, rim), 1.0);
    }
  }
}

TEST(SignedDistance, DerivativesMatchFiniteDifferences) {
  std::mt19937 random(3);
  constexpr double h = 1e-6;
  for (int i = 0; i < 2000; ++i) {
    const Case c = random_case(random);
    const SignedDistance d = signed_distance(c.obstacle, c.p_MQ);
    // Inside, and near a corner, the second derivative is bounded on purpose.
    if (d.value < (is_rectangle(c.obstacle) ? 0.05 : 1e-3)) continue;
    const Eigen::Vector2d t{-d.normal.y(), d.normal.x()};
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d e = h * Eigen::Vector2d::Unit(axis);
      const auto plus = signed_distance(c.obstacle, c.p_MQ + e);
      const auto minus = signed_distance(c.obstacle, c.p_MQ - e);
      EXPECT_NEAR(d.normal[axis], (plus.value - minus.value) / (2 * h), 1e-6);
      const Eigen::Vector2d column = d.curvature * t * t[axis];
      // relative to the curvature: near the tip of a thin wall it reaches 1/mm
      EXPECT_LT((column - (plus.normal - minus.normal) / (2 * h)).norm(),
                1e-5 * std::max(1.0, d.curvature * d.curvature));
    }
  }
}

TEST(SignedDistance, NormalPointsOutOfTheShapeFromInside) {
  std::mt19937 random(4);
  for (int i = 0; i < 2000; ++i) {
    const Case c = random_case(random);
    const SignedDistance d = signed_distance(c.obstacle, c.p_MQ);
    EXPECT_NEAR(d.normal.norm(), 1.0, 1e-9);
    EXPECT_TRUE(std::isfinite(d.curvature));
    EXPECT_NEAR(level(c.obstacle, c.p_MQ - d.value * d.normal), 1.0, 1e-5);
  }
}

}  // namespace
}  // namespace tandem
