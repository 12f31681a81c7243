// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/cell_hull.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>
#include <utility>
#include <vector>

#include "tandem/model/convex_hull.hpp"

namespace tandem::test {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

// A few runs of cells, with gaps between rows, somewhere on the map.
Cells random_cells(std::mt19937& random) {
  const auto number = [&](int low, int high) {
    return std::uniform_int_distribution<int>{low, high}(random);
  };
  Cells cells;
  const int runs = number(1, 6), x = number(-200, 200), y = number(-200, 200);
  for (int run = 0; run < runs; ++run) {
    const int first = x + number(0, 20), row = y + number(0, 15), length = number(1, 12);
    for (int i = 0; i < length; ++i) cells.push_back({first + i, row});
  }
  return cells;
}

// The hull of all corners of all cells, by the hull of points.
Pairs expected_hull(const Cells& cells) {
  std::vector<Eigen::Vector2d> points;
  for (const CellIndex& cell : cells)
    for (const int dx : {0, 1})
      for (const int dy : {0, 1}) points.emplace_back(cell.ix + dx, cell.iy + dy);
  Pairs corners;
  for (const auto& p : convex_hull(points))
    corners.emplace_back(static_cast<int>(p.x()), static_cast<int>(p.y()));
  return corners;
}

Pairs pairs(const CellCorners& corners) {
  Pairs all;
  for (const CellIndex& corner : corners) all.emplace_back(corner.ix, corner.iy);
  return all;
}

TEST(CellHull, OfOneCellIsItsSquare) {
  EXPECT_EQ(pairs(hull_of({{3, -2}})), (Pairs{{3, -2}, {4, -2}, {4, -1}, {3, -1}}));
}

TEST(CellHull, IsThatOfTheCellsCorners) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Cells cells = random_cells(random);
    ASSERT_EQ(pairs(hull_of(cells)), expected_hull(cells)) << i;
  }
}

TEST(CellHull, OfTwoHullsIsThatOfAllCells) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    Cells cells = random_cells(random);
    const Cells others = random_cells(random);
    const CellCorners both = hull_of_both(hull_of(cells), hull_of(others));
    cells.insert(cells.end(), others.begin(), others.end());
    ASSERT_EQ(pairs(both), expected_hull(cells)) << i;
  }
}

}  // namespace
}  // namespace tandem::test
