// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/cost_to_go.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tandem {
namespace {

Grid free_square(int cells) {
  const auto size = static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells);
  return {0.05, {0.0, 0.0}, cells, cells, std::vector<Cell>(size, Cell::kFree)};
}

// 4 m × 4 m with a wall at x = 2 that is open above y = 3.
StaticMap walled() {
  Grid grid = free_square(80);
  for (int iy = 0; iy < 60; ++iy) grid.cells[grid.index(40, iy)] = Cell::kOccupied;
  return StaticMap{std::move(grid), true};
}

TEST(CostToGo, IsTheDistanceWhereNothingStandsWhicheverTheDirection) {
  const Eigen::Vector2d goal{3.0, 3.0};
  const StaticMap map{free_square(120)};
  const CostToGo cost{map, goal, 0.3};
  for (double angle = 0.0; angle < 2.0 * std::numbers::pi; angle += 0.1) {
    const Eigen::Vector2d away{std::cos(angle), std::sin(angle)};
    EXPECT_NEAR(cost.at(goal + 2.0 * away), 2.0, 0.06) << angle;
    const double heading = cost.downhill(goal + 2.0 * away);
    EXPECT_NEAR(wrap_angle(heading - angle - std::numbers::pi), 0.0, 0.05) << angle;
  }
}

TEST(CostToGo, LeadsRoundAWall) {
  const StaticMap map = walled();
  const CostToGo cost{map, {3.0, 0.5}, 0.1, 0.0};
  const double corner = std::hypot(1.0, 2.6);  // past the wall's end, 0.1 m from it
  EXPECT_NEAR(cost.at({1.0, 0.5}), 2.0 * corner, 0.3);
  EXPECT_GT(cost.downhill({1.0, 0.5}), 0.9);  // up, not at the goal
  EXPECT_LT(cost.downhill({1.0, 0.5}), 1.6);
}

TEST(CostToGo, IsNeverLessThanTheStraightLineAndAsLongAsAFoundPath) {
  const StaticMap map = walled();
  const Eigen::Vector2d goal{3.0, 0.5};
  const CostToGo cost{map, goal, 0.2, 0.0};
  for (double x = 0.3; x < 3.8; x += 0.31)
    for (double y = 0.3; y < 3.8; y += 0.31) {
      if (map.distance({x, y}) < 0.25) continue;
      const auto way = find_path(map, {x, y}, goal, 0.2, 0.0);
      ASSERT_FALSE(way.empty());
      double length = 0.0;
      for (std::size_t i = 1; i < way.size(); ++i) length += (way[i] - way[i - 1]).norm();
      EXPECT_GE(cost.at({x, y}), (goal - Eigen::Vector2d{x, y}).norm() - 0.05);
      EXPECT_LE(cost.at({x, y}), 1.02 * length + 0.1) << x << ", " << y;
    }
}

TEST(CostToGo, IsInfiniteWhereNoPathLeads) {
  const StaticMap map = walled();
  EXPECT_TRUE(std::isinf(CostToGo(map, {3.0, 0.5}, 0.6, 0.0).at({1.0, 0.5})));  // too wide
  const CostToGo cost{map, {3.0, 0.5}, 0.1};
  EXPECT_TRUE(std::isinf(cost.at({-1.0, 0.5})));
  EXPECT_TRUE(std::isinf(cost.at({std::nan(""), 0.5})));
  EXPECT_EQ(cost.downhill({-1.0, 0.5}), 0.0);
  EXPECT_TRUE(std::isinf(CostToGo(map, {30.0, 0.5}, 0.1).at({1.0, 0.5})));
}

}  // namespace
}  // namespace tandem
