// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/passages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "tandem/obstacle_extractor/extractor.hpp"

namespace tandem {
namespace {

// A wall across 6 m × 4 m, 0.1 m thick, with doors from these y on.
struct Hall {
  explicit Hall(double wide, const std::vector<double>& doors = {0.5}) {
    Grid grid{0.05, {0.0, 0.0}, 120, 80, std::vector<Cell>(9600, Cell::kFree)};
    for (int iy = 0; iy < 80; ++iy) {
      const double y = 0.05 * (iy + 0.5);
      if (std::any_of(doors.begin(), doors.end(),
                      [&](double door) { return y > door && y < door + wide; }))
        continue;
      for (const int ix : {59, 60}) {
        grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
        wall.push_back({ix, iy});
      }
    }
    map = std::make_unique<StaticMap>(std::move(grid));
  }

  [[nodiscard]] Passages ways(double width = 0.43) const { return past({wall}, width); }
  [[nodiscard]] Passages past(const std::vector<std::vector<CellIndex>>& clusters,
                              double width) const {
    return {*map, FreeRegions{*map, 0.42}, {0, 0, 120, 80}, 0, width, clusters};
  }

  std::vector<CellIndex> wall;
  std::unique_ptr<StaticMap> map;
};

Obstacle across(double y_low, double y_high) {
  return {.p_MO = {3.0, 0.5 * (y_low + y_high)},
          .a = 0.5 * (y_high - y_low),
          .b = 0.1,
          .angle = 1.5707963267948966};
}

TEST(Passages, ADoorThatCoarserShapesCloseIsFound) {
  const Hall hall(0.8);
  const Passages ways = hall.ways();
  const std::vector<Obstacle> fine{across(-0.6, 0.55), across(1.25, 4.0)};
  const std::vector<Obstacle> coarse{across(-0.6, 0.70), across(1.15, 4.0)};
  const auto cells = ways.closed(fine, coarse);
  ASSERT_FALSE(cells.empty());
  EXPECT_EQ(cells[ways.window().index(60, 18)], 1);  // in the door
  EXPECT_EQ(cells[ways.window().index(60, 60)], 0);  // in the wall
  EXPECT_EQ(cells[ways.window().index(10, 40)], 0);  // in a room
}

TEST(Passages, ADoorThatOnlyGetsNarrowerIsNotReported) {
  const Hall hall(0.8);
  const std::vector<Obstacle> fine{across(-0.6, 0.55), across(1.25, 4.0)};
  const std::vector<Obstacle> coarse{across(-0.6, 0.60), across(1.25, 4.0)};
  EXPECT_TRUE(hall.ways().closed(fine, coarse).empty());
}

TEST(Passages, AWiderRobotNeedsAWiderDoor) {
  const Hall hall(0.8);
  const std::vector<Obstacle> fine{across(-0.6, 0.5), across(1.3, 4.0)};
  const std::vector<Obstacle> coarse{across(-0.6, 0.6), across(1.25, 4.0)};
  EXPECT_TRUE(hall.ways(0.43).closed(fine, coarse).empty());
  EXPECT_FALSE(hall.ways(0.60).closed(fine, coarse).empty());
}

TEST(Passages, AGapThatWasAlreadyTooNarrowIsNotAPassage) {
  const Hall hall(0.5);
  EXPECT_TRUE(
      hall.ways().closed({across(-0.6, 0.5), across(1.0, 4.0)}, {across(-0.6, 4.0)}).empty());
}

TEST(Passages, ADetourCountsAsAPassage) {
  const Hall hall(0.8, {0.5, 2.5});
  EXPECT_TRUE(hall.ways().closed({across(-0.6, 0.5)}, {across(-0.6, 1.5)}).empty());
}

// Without the wall the shape would close a way that is there before.
TEST(Passages, UncoveredCellsBlockThePassage) {
  const Hall hall(0.55);
  EXPECT_TRUE(hall.past({}, 0.43).closed({}, {across(0.3, 1.4)}).empty());
}

}  // namespace
}  // namespace tandem
