// SPDX-License-Identifier: Apache-2.0
// A room with obstacles, and everything that the fits in it need.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/obstacle_extractor/cover/bounding_shapes.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"
#include "tandem/obstacle_extractor/cover/free_space.hpp"

namespace tandem::test {

/// 6 m × 6 m with some occupied cells in it, and the hull of their corners.
struct Room {
  static constexpr int kCells = 120;
  static constexpr CellRect kWindow{0, 0, kCells, kCells};

  explicit Room(const std::vector<CellIndex>& occupied) {
    Grid grid{0.05, {0.0, 0.0}, kCells, kCells, std::vector<Cell>(kCells * kCells, Cell::kFree)};
    Points corners;
    for (const auto& [ix, iy] : occupied) {
      grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
      for (const double x : {0.05 * ix, 0.05 * (ix + 1)})
        for (const double y : {0.05 * iy, 0.05 * (iy + 1)}) corners.push_back({x, y});
    }
    hull = convex_hull(corners);
    map = std::make_unique<StaticMap>(std::move(grid));
    places = std::make_unique<FreeRegions>(*map, 0.42);
    space = std::make_unique<FreeSpace>(*map, *places, kWindow, 0, 1.0);
  }

  Points hull;
  std::unique_ptr<StaticMap> map;
  std::unique_ptr<FreeRegions> places;
  std::unique_ptr<FreeSpace> space;
};

/// The cells of a rectangle whose lowest cell is (ix, iy).
inline std::vector<CellIndex> block(int ix, int iy, int width, int height) {
  std::vector<CellIndex> cells;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) cells.push_back({ix + x, iy + y});
  return cells;
}

/// The cells of both.
inline std::vector<CellIndex> joined(std::vector<CellIndex> a, const std::vector<CellIndex>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// From one cell to a wall of 2 m, at any angle, 1 to 4 cells thick. A cell may be listed twice.
inline std::vector<CellIndex> random_wall(unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> angle{0.0, 3.14}, length{0.0, 2.0};
  const double turn = angle(random), end = length(random);
  const double thick = 0.05 * static_cast<double>(1 + random() % 4);
  std::vector<CellIndex> cells;
  for (double s = 0.0; s <= end; s += 0.02)
    for (double across = 0.0; across < thick; across += 0.02)
      cells.push_back(
          {static_cast<int>((3.0 + s * std::cos(turn) - across * std::sin(turn)) / 0.05),
           static_cast<int>((3.0 + s * std::sin(turn) + across * std::cos(turn)) / 0.05)});
  return cells;
}

}  // namespace tandem::test
