// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/shortest_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tandem {
namespace {

constexpr double kCell = 0.05;

// 6 m × 6 m, empty but for a wall from (3, 0) to (3, `height`).
StaticMap room(double height) {
  Grid grid{kCell, {0.0, 0.0}, 120, 120, std::vector<Cell>(14400, Cell::kFree)};
  for (int iy = 0; kCell * iy < height; ++iy)
    grid.cells[static_cast<std::size_t>(120 * iy + 60)] = Cell::kOccupied;
  return StaticMap{std::move(grid)};
}

const Footprint kRobot = rectangle(0.8, 0.4, 0.0);
const Goal kGoal = PoseGoal{{5.0, 1.0, 0.0}, 0.25};

TEST(ShortestWay, IsStraightWhereNothingStandsInTheWay) {
  EXPECT_NEAR(shortest_path(room(0.0), kRobot, {1.0, 1.0, 0.0}, kGoal).value(), 3.75, 0.02);
}

TEST(ShortestWay, GoesTautRoundTheEndOfAWall) {
  // Up to the disc round the wall's end and down again: the taut string touches a circle of 0.2 m
  // about (3, 3); the grid and its distances are coarser by a cell's diagonal.
  const double there = std::sqrt(2.0 * 2.0 + 2.0 * 2.0 - 0.04);
  const double round = 0.2 * 2.0 * (std::asin(0.2 / std::sqrt(8.0)) + std::atan2(2.0, 2.0));
  const double exact = 2.0 * there + round - 0.25;
  const double length = shortest_path(room(3.0), kRobot, {1.0, 1.0, 0.0}, kGoal).value();
  EXPECT_GT(length, exact - 0.01);
  EXPECT_LT(length, exact + 0.35);
}

// A fork does not contain base_link, so the disc is that of the body.
TEST(ShortestWay, OfARobotOfSeveralPartsIsThatOfThePartAroundItsOrigin) {
  const Footprint forks = polygons({{{0.3, -0.2}, {1.2, -0.2}, {1.2, -0.1}, {0.3, -0.1}},
                                    {{0.3, 0.1}, {1.2, 0.1}, {1.2, 0.2}, {0.3, 0.2}},
                                    {{-0.4, -0.2}, {0.4, -0.2}, {0.4, 0.2}, {-0.4, 0.2}}});
  EXPECT_EQ(shortest_path(room(3.0), forks, {1.0, 1.0, 0.0}, kGoal),
            shortest_path(room(3.0), kRobot, {1.0, 1.0, 0.0}, kGoal));
}

TEST(ShortestWay, IsEmptyWithoutAReachableGoal) {
  EXPECT_FALSE(shortest_path(room(0.0), kRobot, {1.0, 1.0, 0.0}, RoamGoal{}).has_value());
  EXPECT_FALSE(shortest_path(room(6.0), kRobot, {1.0, 1.0, 0.0}, kGoal).has_value());
}

}  // namespace
}  // namespace tandem
