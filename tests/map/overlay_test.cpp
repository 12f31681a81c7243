// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/overlay.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tandem {
namespace {

Grid random_grid(std::mt19937& random, double resolution, const Eigen::Vector2d& origin) {
  Grid grid{resolution, origin, 60, 50, {}};
  for (int i = 0; i < grid.width * grid.height; ++i)
    grid.cells.push_back(static_cast<Cell>(random() % 3));
  return grid;
}

// The cell of a grid that contains a point; unknown outside the grid.
Cell at(const Grid& grid, const Eigen::Vector2d& p) {
  const int ix = static_cast<int>(std::floor((p.x() - grid.origin.x()) / grid.resolution));
  const int iy = static_cast<int>(std::floor((p.y() - grid.origin.y()) / grid.resolution));
  return grid.contains(ix, iy) ? grid.at(ix, iy) : Cell::kUnknown;
}

// Every cell holds exactly what both grids hold at its points.
void expect_both(const Grid& base, const Grid& live, const Grid& out) {
  for (int iy = 0; iy < out.height; ++iy)
    for (int ix = 0; ix < out.width; ++ix) {
      bool occupied = false, free = false;
      for (const double u : {0.01, 0.26, 0.51, 0.76, 0.99})
        for (const double v : {0.01, 0.26, 0.51, 0.76, 0.99}) {
          const Eigen::Vector2d p = out.origin + out.resolution * Eigen::Vector2d(ix + u, iy + v);
          for (const Cell cell : {at(base, p), at(live, p)}) {
            occupied = occupied || cell == Cell::kOccupied;
            free = free || cell == Cell::kFree;
          }
        }
      const Cell expected = occupied ? Cell::kOccupied : free ? Cell::kFree : Cell::kUnknown;
      ASSERT_EQ(out.at(ix, iy), expected) << ix << ", " << iy;
    }
}

TEST(Overlay, ACellTakesTheStrongerStateOfBothGrids) {
  std::mt19937 random{1};
  for (const double resolution : {0.05, 0.1, 0.025}) {  // of the static map
    const Grid base = random_grid(random, resolution, {-1.0, 0.5});
    const Grid live = random_grid(random, 0.05, {-0.35, 0.15});
    const Grid out = overlay(base, live, {0.33, 1.47}, 3.0);
    EXPECT_EQ(out.resolution, 0.05);
    expect_both(base, live, out);
  }
}

TEST(Overlay, OnlyCellsUnknownToBothGridsStayUnknown) {
  std::mt19937 random{1};
  const Grid grid = random_grid(random, 0.05, {0.0, 0.0});
  const Grid unknown = unknown_cells(grid);
  for (std::size_t i = 0; i < grid.cells.size(); ++i)
    EXPECT_EQ(unknown.cells[i], grid.cells[i] == Cell::kUnknown ? Cell::kUnknown : Cell::kFree);
}

TEST(Overlay, AMapOfObstaclesAloneKnowsTheGroundOfItsBox) {
  std::mt19937 random{1};
  const Grid grid = random_grid(random, 0.05, {0.0, 0.0});
  EXPECT_EQ(with_known_ground(grid).cells, grid.cells);
  Grid walls = grid;
  std::replace(walls.cells.begin(), walls.cells.end(), Cell::kFree, Cell::kUnknown);
  for (std::size_t i = 0; i < grid.cells.size(); ++i)
    EXPECT_EQ(with_known_ground(walls).cells[i],
              walls.cells[i] == Cell::kOccupied ? Cell::kOccupied : Cell::kFree);
}

TEST(Overlay, ReachesAsFarAsAskedAndStandsStillForSmallSteps) {
  const Grid live{0.05, {0.0, 0.0}, 0, 0, {}};
  std::mt19937 random{1};
  std::uniform_real_distribution<double> metres(-50.0, 50.0);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d p{metres(random), metres(random)};
    const Grid out = overlay({}, live, p, 4.0);
    const Eigen::Vector2d high = out.origin + 0.05 * Eigen::Vector2d(out.width, out.height);
    EXPECT_LE((out.origin - p).maxCoeff(), -4.0 + 1e-9);
    EXPECT_GE((high - p).minCoeff(), 4.0 - 1e-9);
    EXPECT_LE(out.width, 9.1 / 0.05);
    const Eigen::Vector2d metre = out.origin.array().round();
    EXPECT_LT((out.origin - metre).norm(), 1e-9);
  }
}

TEST(Overlay, RefusesToGrowBeyondTheMemory) {
  Grid live;
  live.resolution = 0.001;
  EXPECT_THROW((void)overlay(Grid{}, live, {0.0, 0.0}, 10.0), std::runtime_error);
  EXPECT_THROW((void)overlay(Grid{}, live, {0.0, 0.0}, 1e9), std::runtime_error);
}

}  // namespace
}  // namespace tandem
