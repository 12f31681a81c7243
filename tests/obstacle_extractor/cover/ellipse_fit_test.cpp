// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/ellipse_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "obstacle_extractor/cover/room.hpp"

namespace tandem::test {
namespace {

constexpr FitLimits kLoose{.excess = {9.0, 9.0, 9.0}, .price = 9.0, .circle_bonus = 0.0};

EllipseFit fit_in(const Room& room, const FitLimits& limits = kLoose) {
  return fit_ellipse(room.hull, *room.space, limits);
}

// 1 on the outline.
double inside(const Obstacle& shape, const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d p_OQ = Eigen::Rotation2Dd(-shape.angle) * (p_MQ - shape.p_MO);
  return std::hypot(p_OQ.x() / shape.a, p_OQ.y() / shape.b);
}

TEST(EllipseFit, ContainsEveryCellOfAnyWall) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Room room(random_wall(seed));
    for (const double price : {9.0, 0.1, 0.0}) {
      FitLimits limits = kLoose;
      limits.price = price;
      const EllipseFit fit = fit_in(room, limits);
      EXPECT_GE(fit.shape.a, fit.shape.b) << seed;
      EXPECT_GT(fit.shape.b, 0.0) << seed;
      for (const auto& corner : room.hull) EXPECT_LE(inside(fit.shape, corner), 1.0) << seed;
    }
  }
}

TEST(EllipseFit, TakesNoMoreThanTheCircleAndWhatItReports) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Room room(random_wall(seed));
    const EllipseFit fit = fit_in(room);
    ASSERT_TRUE(fit.found) << seed;
    EXPECT_NEAR(fit.taken, room.space->taken_by(fit.shape), 1e-9) << seed;
    const Circle circle = smallest_circle(room.hull);
    const Obstacle round{.p_MO = circle.p_MC, .a = circle.radius, .b = circle.radius};
    EXPECT_LE(fit.taken, room.space->taken_by(round) + 1e-6) << seed;
  }
}

TEST(EllipseFit, ABonusMakesTheCircleOfASquareTheChoice) {
  std::vector<CellIndex> square;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 8; ++k) square.push_back({56 + i, 56 + k});
  const Room room(square);
  FitLimits limits = kLoose;
  limits.circle_bonus = 1.0;
  const EllipseFit fit = fit_in(room, limits);
  EXPECT_EQ(fit.shape.a, fit.shape.b);
  EXPECT_NEAR(fit.shape.a, 0.2 * std::sqrt(2.0), 1e-6);
}

TEST(EllipseFit, AWallIsCoveredFlat) {
  std::vector<CellIndex> wall;
  for (int i = 0; i < 60; ++i) wall.push_back({30 + i, 60});
  const EllipseFit fit = fit_in(Room(wall));
  EXPECT_LT(fit.shape.b, 0.15);
  EXPECT_GT(fit.shape.a, 1.5);
  EXPECT_LT(fit.shape.a, 2.2);
  EXPECT_NEAR(std::sin(fit.shape.angle), 0.0, 0.05);
  EXPECT_NEAR(std::sin(fit.length_angle), 0.0, 1e-9);
}

TEST(EllipseFit, FindsNothingWhereNoShapeIsWithinTheLimits) {
  std::vector<CellIndex> wall;
  for (int i = 0; i < 60; ++i) wall.push_back({30 + i, 60});
  const Room room(wall);
  FitLimits dear = kLoose, shallow = kLoose;
  dear.price = -1.0;
  shallow.excess = {0.0, 0.0, 0.0};
  for (const FitLimits& limits : {dear, shallow}) {
    const EllipseFit fit = fit_in(room, limits);
    EXPECT_FALSE(fit.found);
    EXPECT_EQ(fit.shape.a, fit.shape.b) << "a circle";
  }
}

}  // namespace
}  // namespace tandem::test
