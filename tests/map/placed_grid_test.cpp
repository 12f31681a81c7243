// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/placed_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tandem {
namespace {

// 20 × 30 cells of 0.1 m, not at the origin, free except for the given ones.
Grid hall(std::initializer_list<std::pair<int, int>> occupied) {
  Grid grid{.resolution = 0.1, .origin = {-0.53, 1.27}, .width = 20, .height = 30, .cells = {}};
  grid.cells.assign(600, Cell::kFree);
  for (const auto& [ix, iy] : occupied) grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
  return grid;
}

Cell cell_at(const Grid& grid, const Eigen::Vector2d& p) {
  const Eigen::Vector2d q = (p - grid.origin) / grid.resolution;
  const int ix = static_cast<int>(std::floor(q.x())), iy = static_cast<int>(std::floor(q.y()));
  return grid.contains(ix, iy) ? grid.at(ix, iy) : Cell::kUnknown;
}

TEST(PlacedGrid, IsShiftedAsItIsWithoutATurn) {
  const Grid grid = hall({{3, 4}});
  const Grid moved = placed(grid, {1.013, -2.0, 0.0});
  EXPECT_EQ(moved.cells, grid.cells);
  EXPECT_NEAR(moved.origin.x(), -0.53 + 1.013, 1e-12);
  EXPECT_NEAR(moved.origin.y(), 1.27 - 2.0, 1e-12);
}

// Points of occupied and unknown squares, grown by the spread, at random poses.
TEST(PlacedGrid, LosesNoPointOfAnObstacleHoweverItIsTurned) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> place{-5.0, 5.0}, unit{0.0, 1.0};
  std::uniform_int_distribution<int> x{0, 19}, y{0, 29};
  for (int i = 0; i < 300; ++i) {
    Grid grid = hall({});
    const int ix = x(random), iy = y(random);
    const Cell kind = i % 2 == 0 ? Cell::kOccupied : Cell::kUnknown;
    grid.cells[grid.index(ix, iy)] = kind;
    const double spread = i % 3 == 0 ? 0.0 : 0.03;
    const Pose2 X_MF{place(random), place(random), place(random)};
    const Grid out = placed(grid, X_MF, spread);
    for (int k = 0; k < 200; ++k) {
      const Eigen::Vector2d inside{unit(random), unit(random)};
      const Eigen::Vector2d p_F =
          grid.origin + grid.resolution * Eigen::Vector2d(ix, iy) -
          Eigen::Vector2d::Constant(spread) +
          (grid.resolution + 2.0 * spread) * (0.0005 + 0.999 * inside.array()).matrix();
      EXPECT_EQ(cell_at(out, transform(X_MF, p_F)), kind);
    }
  }
}

TEST(PlacedGrid, MakesAnObstacleNoLargerThanTheCellsThatItReaches) {
  const Grid grid = hall({{10, 15}});
  for (const double turn : {0.2, 0.785, 1.7, -2.9}) {
    const Pose2 X_MF{0.4, -1.3, turn};
    const Grid out = placed(grid, X_MF);
    const Eigen::Vector2d middle = transform(X_MF, grid.center(10, 15));
    int occupied = 0;
    for (int iy = 0; iy < out.height; ++iy)
      for (int ix = 0; ix < out.width; ++ix)
        if (out.at(ix, iy) == Cell::kOccupied) {
          ++occupied;
          EXPECT_LT((out.center(ix, iy) - middle).norm(), 0.1 * std::sqrt(2.0) + 1e-9);
        }
    EXPECT_LE(occupied, 9);
    EXPECT_GE(occupied, 1);
  }
}

TEST(PlacedGrid, IsFreeWhereAllIsFreeAndUnknownBeyondIt) {
  const Grid grid = hall({});
  const Pose2 X_MF{2.0, 1.0, 0.6};
  const Grid out = placed(grid, X_MF);
  EXPECT_EQ(cell_at(out, transform(X_MF, grid.center(10, 15))), Cell::kFree);
  EXPECT_EQ(cell_at(out, transform(X_MF, grid.center(2, 2))), Cell::kFree);
  EXPECT_EQ(cell_at(out, transform(X_MF, grid.center(-2, 2))), Cell::kUnknown);
}

TEST(PlacedGrid, RefusesMoreCellsThanAGridMayHave) {
  Grid line{.resolution = 0.01, .origin = {0.0, 0.0}, .width = 2'000'000, .height = 1, .cells = {}};
  line.cells.assign(2'000'000, Cell::kFree);
  EXPECT_THROW((void)placed(line, {0.0, 0.0, 0.785}), std::runtime_error);
}

}  // namespace
}  // namespace tandem
