// SPDX-License-Identifier: Apache-2.0
// Free regions of random maps, against distances and connections that are searched for cell by
// cell.
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

namespace tandem {
namespace {

constexpr double kResolution = 0.1;
constexpr std::size_t kPocket = 25;  // cells: a region must have more, 0.25 m²

// Walls of random cells and lines; some cells are unknown.
Grid random_grid(unsigned seed) {
  std::mt19937 random{seed};
  const int width = 12 + static_cast<int>(random() % 20),
            height = 12 + static_cast<int>(random() % 20);
  Grid grid{kResolution,
            {-1.0, 0.5},
            width,
            height,
            std::vector<Cell>(static_cast<std::size_t>(width * height), Cell::kFree)};
  const auto at = [&](int ix, int iy) -> Cell& { return grid.cells[grid.index(ix, iy)]; };
  for (int i = 0; i < 3; ++i) {
    const int x = static_cast<int>(random()) % width, door = static_cast<int>(random() % 20);
    for (int iy = 0; iy < height; ++iy)
      if (std::abs(iy - door) > 1 + static_cast<int>(random() % 2))
        at(std::abs(x), iy) = Cell::kOccupied;
  }
  for (int i = 0; i < 6; ++i)
    grid.cells[random() % grid.cells.size()] = i % 2 == 0 ? Cell::kOccupied : Cell::kUnknown;
  return grid;
}

// Distance from the cell's centre to the nearest square that is not free, in cells.
double gap_of(const Grid& grid, int ix, int iy) {
  double least = std::numeric_limits<double>::infinity();
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      if (grid.at(x, y) == Cell::kFree) continue;
      const bool is_here = x == ix && y == iy;
      least = std::min(least, is_here ? 0.0
                                      : std::hypot(std::max(0.0, std::abs(x - ix) - 0.5),
                                                   std::max(0.0, std::abs(y - iy) - 0.5)));
    }
  return least;
}

// Labels of the cells whose gap is at least `radius`, spread from neighbour to neighbour until
// nothing changes; 0 elsewhere.
std::map<std::pair<int, int>, int> labels_of(const Grid& grid, double radius) {
  std::map<std::pair<int, int>, int> labels;
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix)
      if (gap_of(grid, ix, iy) >= std::max(0.5, radius))
        labels[{ix, iy}] = 1 + static_cast<int>(labels.size());
  for (bool changed = true; std::exchange(changed, false);)
    for (auto& [cell, label] : labels)
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        if (const auto other = labels.find({cell.first + dx, cell.second + dy});
            other != labels.end() && other->second < label) {
          label = other->second;
          changed = true;
        }
  return labels;
}

TEST(FreeRegions, AreTheConnectedPlacesOfTheDisc) {
  std::set<int> counts;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Grid grid = random_grid(seed);
    const double gap = 0.1 * static_cast<double>(seed % 5);
    const FreeRegions regions{StaticMap{grid}, gap};
    auto labels = labels_of(grid, regions.radius());
    std::map<int, std::size_t> sizes;
    for (const auto& [cell, label] : labels) ++sizes[label];
    std::map<int, int> region_of;  // by label
    for (int iy = 0; iy < grid.height; ++iy)
      for (int ix = 0; ix < grid.width; ++ix) {
        const auto label = labels.find({ix, iy});
        const bool counts_as_place = label != labels.end() && sizes[label->second] > kPocket;
        const int region = regions.region(ix, iy);
        ASSERT_EQ(region > 0, counts_as_place) << seed << ": " << ix << ", " << iy;
        if (region > 0) {
          EXPECT_EQ(region_of.emplace(label->second, region).first->second, region) << seed;
        }
      }
    std::set<int> distinct;
    for (const auto& [label, region] : region_of) distinct.insert(region);
    EXPECT_EQ(distinct.size(), region_of.size()) << "two regions of one number, " << seed;
    counts.insert(static_cast<int>(distinct.size()));
  }
  EXPECT_GT(counts.size(), 2U) << "maps of one, two and more regions";
}

TEST(FreeRegions, KnowTheDistanceToTheNearestCellThatIsNotFree) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Grid grid = random_grid(seed);
    const FreeRegions regions{StaticMap{grid}, 0.4};
    const double exact = regions.radius() + FreeRegions::kBeyond;
    for (int iy = 0; iy < grid.height; ++iy)
      for (int ix = 0; ix < grid.width; ++ix) {
        const double gap = regions.gap(ix, iy), right = gap_of(grid, ix, iy);
        ASSERT_NEAR(std::min(gap, exact), std::min(right, exact), 1e-4) << seed;
        ASSERT_LT(gap, right + 1e-4) << seed;
      }
    EXPECT_EQ(regions.gap(-1, 0), 0.0F) << "outside";
    EXPECT_EQ(regions.region(grid.width, 0), 0) << "outside";
  }
}

TEST(FreeRegions, TheRegionAtAPointIsThatOfTheNearestPlaceWithinReach) {
  std::mt19937 random{5};
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Grid grid = random_grid(seed);
    const FreeRegions regions{StaticMap{grid}, 0.4};
    std::uniform_real_distribution<double> x{-1.5, 2.5}, y{0.0, 4.0};
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d p_MQ{x(random), y(random)};
      double least = FreeRegions::kBeside;
      int nearest = 0;
      for (int iy = 0; iy < grid.height; ++iy)
        for (int ix = 0; ix < grid.width; ++ix)
          if (const double d = (grid.center(ix, iy) - p_MQ).norm();
              regions.region(ix, iy) > 0 && d < least) {
            least = d;
            nearest = regions.region(ix, iy);
          }
      EXPECT_EQ(regions.region_at(p_MQ), nearest) << seed << ": " << p_MQ.transpose();
      if (nearest > 0) {
        EXPECT_TRUE(regions.is_beside(p_MQ, nearest)) << seed;
      }
    }
  }
}

TEST(FreeRegions, AMapWithoutFreeCellsIsFreeAroundItsObstacles) {
  Grid grid{kResolution, {0.0, 0.0}, 10, 10, std::vector<Cell>(100, Cell::kUnknown)};
  grid.cells[grid.index(5, 5)] = Cell::kOccupied;
  const FreeRegions regions{StaticMap{grid}, 0.4};
  EXPECT_EQ(regions.region(0, 0), 1);
  EXPECT_EQ(regions.region(-20, 5), 1);
  EXPECT_EQ(regions.region(5, 5), 0);
  EXPECT_EQ(regions.region(6, 5), 0) << "too near";
}

TEST(FreeRegions, RefuseAGapThatIsNoWidth) {
  const StaticMap map{random_grid(1)};
  EXPECT_THROW((FreeRegions{map, -0.1}), std::invalid_argument);
  EXPECT_THROW((FreeRegions{map, std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
