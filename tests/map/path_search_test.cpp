// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/path_search.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tandem {
namespace {

// 4 m × 4 m with a wall at x = 2 that has two openings: 0.4 m wide at y = 1, 1.2 m wide at y = 3.
StaticMap two_openings() {
  Grid grid{0.05, {0.0, 0.0}, 80, 80, std::vector<Cell>(6400, Cell::kFree)};
  for (int iy = 0; iy < 80; ++iy) {
    const double y = 0.05 * (iy + 0.5);
    const bool open = std::abs(y - 1.0) < 0.2 || std::abs(y - 3.0) < 0.6;
    if (!open) grid.cells[static_cast<std::size_t>(80 * iy + 40)] = Cell::kOccupied;
  }
  return StaticMap{std::move(grid), true};
}

double largest_y(const std::vector<Eigen::Vector2d>& way) {
  double y = 0.0;
  for (const auto& p : way) y = std::max(y, p.y());
  return y;
}

TEST(Way, KeepsTheDiscClearAndItsEnds) {
  const StaticMap map = two_openings();
  const Eigen::Vector2d a{0.7, 1.0}, z{3.3, 1.0};
  for (const double radius : {0.1, 0.3}) {
    const auto way = find_path(map, a, z, radius);
    ASSERT_GE(way.size(), 3);
    EXPECT_EQ(way.front(), a);
    EXPECT_EQ(way.back(), z);
    for (std::size_t i = 1; i + 1 < way.size(); ++i)
      EXPECT_GE(map.distance(way[i]), radius - 1e-6) << way[i].transpose();
  }
}

TEST(Way, TakesTheWideOpeningIfOnlyThatIsWideEnough) {
  const StaticMap map = two_openings();
  EXPECT_GT(largest_y(find_path(map, {0.7, 1.0}, {3.3, 1.0}, 0.3)), 2.3);
  EXPECT_TRUE(find_path(map, {0.7, 1.0}, {3.3, 1.0}, 0.7).empty());
}

TEST(Way, IsEmptyFromOutsideTheMap) {
  EXPECT_TRUE(find_path(two_openings(), {-1.0, 1.0}, {3.3, 1.0}, 0.1).empty());
}

TEST(Way, ExistsWhereOneIsFound) {
  std::mt19937 random{1};
  int found = 0, tried = 0;
  for (int n = 0; n < 40; ++n) {
    Grid grid{0.1, {0.0, 0.0}, 30, 30, std::vector<Cell>(900, Cell::kFree)};
    for (auto& cell : grid.cells)
      if (random() % 24 == 0) cell = Cell::kOccupied;
    const StaticMap map{std::move(grid), true};
    for (const double radius : {0.0, 0.05, 0.1, 0.15, 0.2, 0.3}) {
      const bool is_found = !find_path(map, {0.55, 0.55}, {2.45, 2.45}, radius).empty();
      EXPECT_EQ(has_path(map, {0.55, 0.55}, {2.45, 2.45}, radius), is_found);
      found += is_found;
      ++tried;
    }
  }
  EXPECT_GT(found, tried / 5);
  EXPECT_LT(found, 4 * tried / 5);
}

}  // namespace
}  // namespace tandem
