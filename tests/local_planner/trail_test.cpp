// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/trail.hpp"

#include <gtest/gtest.h>

namespace tandem::test {
namespace {

const Body kDisc{{}, {{{0.0, 0.0}, 0.3}}, true};

double length(const std::vector<Eigen::Vector2d>& points) {
  double sum = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

// A leader along x from 0 to `end`, the robot at the origin.
Trail ahead(double end) {
  Trail trail;
  for (double x = 0.0; x <= end + 1e-9; x += 0.045) trail.extend({x, 0.0}, {0.0, 0.0});
  return trail;
}

TEST(Trail, IsTheLeadersPathFromTheRobotOn) {
  Trail trail = ahead(1.0);
  EXPECT_NEAR(length(trail.free_points(kDisc, {}, {})), 1.0, 0.06);
  trail.extend({1.0, 0.0}, {0.6, 0.1});
  const auto rest = trail.free_points(kDisc, {}, {});
  EXPECT_NEAR(rest.front().x(), 0.6, 0.04);
  EXPECT_NEAR(rest.back().x(), 1.0, 0.06);
}

TEST(Trail, IsTakenBackByALeaderThatComesBack) {
  Trail trail = ahead(1.0);
  for (double x = 1.0; x >= 0.3; x -= 0.045) trail.extend({x, 0.05}, {0.0, 0.0});
  const auto points = trail.free_points(kDisc, {}, {});
  EXPECT_LT(length(points), 0.3 + 0.3);
  for (const auto& p : points) EXPECT_LT(p.x(), 0.5);
}

TEST(Trail, StartsOverWhenTheLeaderJumps) {
  Trail trail = ahead(1.0);
  trail.extend({-0.2, 2.0}, {0.0, 0.0});
  const auto points = trail.free_points(kDisc, {}, {});
  EXPECT_EQ(points.front(), Eigen::Vector2d(0.0, 0.0));
  EXPECT_NEAR(length(points), std::hypot(0.2, 2.0), 0.06);
}

TEST(Trail, SkipsBlockedPointsAndReportsIt) {
  const std::vector<Obstacle> pole{{1, {0.8, 0.0}, 0.1, 0.1, 0.0, {0, 0}}};
  const auto points = ahead(2.0).free_points(kDisc, pole, {.margin = 0.05});
  for (const auto& p : points) EXPECT_GE((p - pole.front().p_MO).norm(), 0.45 - 1e-9);
  EXPECT_FALSE(along(points, {0.0, 0.1}, 0.2).bridges);
  const OnTrail over = along(points, {0.0, 0.1}, 0.8);
  EXPECT_TRUE(over.bridges);
  EXPECT_NEAR(over.p_MT.x(), 0.8, 0.06);
  EXPECT_FALSE(along(points, {0.0, 0.1}, 1.6).bridges);
  EXPECT_NEAR(along(points, {0.0, 0.1}, 9.0).p_MT.x(), 2.0, 0.06);
}

TEST(Trail, KeepsTheLeaderEvenInsideAnObstacle) {
  const std::vector<Obstacle> pole{{1, {1.0, 0.0}, 0.1, 0.1, 0.0, {0, 0}}};
  EXPECT_NEAR(ahead(1.0).free_points(kDisc, pole, {}).back().x(), 1.0, 0.06);
}

TEST(Trail, GoesOnWhereItsLeaderIsExpected) {
  const std::vector<Obstacle> pole{{1, {1.2, 0.0}, 0.1, 0.1, 0.0, {0, 0}}};
  const std::vector<Eigen::Vector2d> onward{{1.05, 0.0}, {1.1, 0.0}, {1.7, 0.0}, {1.75, 0.0}};
  const auto points = ahead(0.5).free_points(kDisc, pole, {}, onward);
  EXPECT_NEAR(points[points.size() - 3].x(), 0.5, 0.06);
  EXPECT_EQ(points[points.size() - 2], onward[2]);
  EXPECT_EQ(points.back(), onward[3]);
}

}  // namespace
}  // namespace tandem::test
