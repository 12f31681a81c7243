// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/cover.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "obstacle_extractor/cover/room.hpp"

namespace tandem::test {
namespace {

using Clusters = std::vector<std::vector<CellIndex>>;

constexpr double kRobotWidth = 0.58;  // [m]
constexpr CoverParams kParams{.excess = {0.3, 0.1, 0.05}, .space_per_shape = 0.1, .crowded = 100};

std::vector<CellIndex> all_cells(const Clusters& clusters) {
  std::vector<CellIndex> cells;
  for (const auto& cluster : clusters) cells.insert(cells.end(), cluster.begin(), cluster.end());
  return cells;
}

std::vector<CoverShape> shapes_of(const Clusters& clusters, const CoverParams& params = kParams) {
  const Room room(all_cells(clusters));
  const Passages passages(*room.map, *room.places, Room::kWindow, 0, kRobotWidth, clusters);
  return cover(room.map->grid(), clusters, *room.space, passages, params);
}

bool covers_cell(const Obstacle& shape, const CellIndex& cell) {
  for (const int dx : {0, 1})
    for (const int dy : {0, 1})
      if (!contains(shape, {0.05 * (cell.ix + dx), 0.05 * (cell.iy + dy)})) return false;
  return true;
}

// Each cell once, as clusters of a map are.
std::vector<CellIndex> unique_wall(unsigned seed) {
  std::set<std::pair<int, int>> seen;
  std::vector<CellIndex> cells = random_wall(seed);
  std::erase_if(cells, [&](const auto& cell) { return !seen.emplace(cell.iy, cell.ix).second; });
  return cells;
}

TEST(Cover, EachCellLiesWhollyInAShape) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto wall = unique_wall(seed);
    const auto shapes = shapes_of({wall});
    for (const CellIndex& cell : wall)
      ASSERT_TRUE(std::any_of(shapes.begin(), shapes.end(), [&](const auto& shape) {
        return covers_cell(shape.obstacle, cell);
      })) << seed;
  }
}

TEST(Cover, EqualArgumentsGiveEqualShapes) {
  const auto wall = unique_wall(3);
  const auto a = shapes_of({wall}), b = shapes_of({wall});
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].obstacle.id, b[i].obstacle.id);
    EXPECT_EQ(a[i].obstacle.p_MO, b[i].obstacle.p_MO);
  }
}

TEST(Cover, APoleIsOneCircle) {
  const auto shapes = shapes_of({block(60, 60, 4, 4)});
  ASSERT_EQ(shapes.size(), 1U);
  EXPECT_EQ(shapes[0].obstacle.a, shapes[0].obstacle.b);
}

TEST(Cover, TwoPolesWithRoomBetweenStayApart) {
  EXPECT_EQ(shapes_of({block(30, 60, 4, 4), block(70, 60, 4, 4)}).size(), 2U);
}

TEST(Cover, TheClustersOfADottedLineAreJoined) {
  EXPECT_EQ(shapes_of({block(50, 60, 3, 2), block(54, 60, 3, 2), block(58, 60, 3, 2)}).size(), 1U);
}

TEST(Cover, ACornerIsSplitIntoItsWalls) {
  std::vector<CellIndex> corner = block(30, 30, 50, 2);
  for (const CellIndex& cell : block(30, 32, 2, 48)) corner.push_back(cell);
  EXPECT_GE(shapes_of({corner}).size(), 2U);
}

// A quarter of a circle of 2 m.
TEST(Cover, ShapesGetCoarserWhenTheyAreTooMany) {
  std::set<std::pair<int, int>> cells;
  for (double angle = 0.0; angle < 1.57; angle += 0.01)
    cells.emplace(static_cast<int>((1.0 + 2.0 * std::sin(angle)) / 0.05),
                  static_cast<int>((1.0 + 2.0 * std::cos(angle)) / 0.05));
  std::vector<CellIndex> arc;
  for (const auto& [ix, iy] : cells) arc.push_back({ix, iy});
  CoverParams few = kParams;
  few.crowded = 2;
  EXPECT_LT(shapes_of({arc}, few).size(), shapes_of({arc}).size());
}

TEST(Cover, IdsAreThoseOfTheLowestCells) {
  const auto shapes = shapes_of({block(30, 60, 4, 4), block(70, 20, 4, 4)});
  std::set<std::uint32_t> ids;
  for (const CoverShape& shape : shapes) ids.insert(shape.obstacle.id);
  EXPECT_EQ(ids, (std::set<std::uint32_t>{60 * Room::kCells + 31, 20 * Room::kCells + 71}));
}

}  // namespace
}  // namespace tandem::test
