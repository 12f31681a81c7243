// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/shape_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "obstacle_extractor/cover/room.hpp"

namespace tandem::test {
namespace {

constexpr FitLimits kLoose{.excess = {9.0, 9.0, 9.0}, .price = 9.0, .circle_bonus = 0.0};

ShapeFit fit_in(const Room& room, const FitLimits& limits = kLoose) {
  return fit_shape(room.hull, *room.space, limits);
}

TEST(ShapeFit, ContainsEveryCellOfAnyWall) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Room room(random_wall(seed));
    for (const double price : {9.0, 0.1, 0.0}) {
      FitLimits limits = kLoose;
      limits.price = price;
      const ShapeFit fit = fit_in(room, limits);
      EXPECT_GE(fit.shape.a, fit.shape.b) << seed;
      EXPECT_GT(fit.shape.b, 0.0) << seed;
      for (const auto& corner : room.hull) EXPECT_TRUE(contains(fit.shape, corner)) << seed;
    }
  }
}

TEST(ShapeFit, TakesNoMoreThanTheCircleAndWhatItReports) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Room room(random_wall(seed));
    const ShapeFit fit = fit_in(room);
    ASSERT_TRUE(fit.found) << seed;
    EXPECT_NEAR(fit.taken, room.space->taken_by(fit.shape), 1e-9) << seed;
    const Circle circle = smallest_circle(room.hull);
    const Obstacle round{.p_MO = circle.p_MC, .a = circle.radius, .b = circle.radius};
    EXPECT_LE(fit.taken, room.space->taken_by(round) + 1e-6) << seed;
  }
}

TEST(ShapeFit, ABonusMakesTheCircleOfASquareTheChoice) {
  std::vector<CellIndex> square;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 8; ++k) square.push_back({56 + i, 56 + k});
  const Room room(square);
  FitLimits limits = kLoose;
  limits.circle_bonus = 1.0;
  const ShapeFit fit = fit_in(room, limits);
  EXPECT_EQ(fit.shape.a, fit.shape.b);
  EXPECT_NEAR(fit.shape.a, 0.2 * std::sqrt(2.0), 1e-6);
}

TEST(ShapeFit, AWallIsCoveredByARectangleThatTakesNothing) {
  const Room room(block(30, 60, 60, 2));
  const ShapeFit fit = fit_in(room);
  EXPECT_TRUE(is_rectangle(fit.shape));
  EXPECT_NEAR(fit.shape.b, 0.05, 1e-6);
  EXPECT_NEAR(fit.shape.a, 1.5, 1e-6);
  EXPECT_NEAR(std::sin(fit.shape.angle), 0.0, 1e-9);
  EXPECT_NEAR(std::sin(fit.length_angle), 0.0, 1e-9);
  EXPECT_LT(fit.taken, 1e-3);
}

// The raster of a slanting wall is a staircase, of which an ellipse may leave more space.
TEST(ShapeFit, TakesNoMoreThanTheSmallestRectangle) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Room room(random_wall(seed));
    const TurnedBox box = smallest_box(room.hull);
    const Obstacle rectangle{.p_MO = box.p_MC,
                             .a = box.half.x(),
                             .b = box.half.y(),
                             .angle = box.angle,
                             .shape = ObstacleShape::kRectangle};
    EXPECT_LE(fit_in(room).taken, room.space->taken_by(rectangle) + 1e-6) << seed;
  }
}

// Corners of a rectangle stay out of a curved corridor that an ellipse fits.
TEST(ShapeFit, AnEllipseIsTakenWhereARectangleWouldReachTooDeep) {
  const Room room(joined(block(50, 60, 20, 2), block(57, 57, 6, 8)));
  FitLimits limits = kLoose;
  const ShapeFit loose = fit_in(room);
  limits.excess = {0.12, 0.12, 0.12};
  const ShapeFit tight = fit_in(room, limits);
  ASSERT_TRUE(loose.found && tight.found);
  EXPECT_FALSE(is_rectangle(tight.shape));
  for (const auto& corner : room.hull) EXPECT_TRUE(contains(tight.shape, corner));
}

TEST(ShapeFit, FindsNothingWhereNoShapeIsWithinTheLimits) {
  std::vector<CellIndex> wall;
  for (int i = 0; i < 60; ++i) wall.push_back({30 + i, 60});
  const Room room(wall);
  FitLimits dear = kLoose, shallow = kLoose;
  dear.price = -1.0;
  shallow.excess = {0.0, 0.0, 0.0};
  for (const FitLimits& limits : {dear, shallow}) {
    const ShapeFit fit = fit_in(room, limits);
    EXPECT_FALSE(fit.found);
    EXPECT_EQ(fit.shape.a, fit.shape.b) << "a circle";
  }
}

}  // namespace
}  // namespace tandem::test
