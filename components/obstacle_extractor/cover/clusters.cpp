// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/clusters.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace tandem {
namespace {

// Finds connected groups of obstacle cells within a window, each once.
class Flood {
 public:
  Flood(const StaticMap& map, const CellRect& window)
      : map_{map},
        window_{window},
        seen_(static_cast<std::size_t>(window.width()) *
              static_cast<std::size_t>(window.height())) {}

  // The group of an obstacle cell; empty if it was returned before.
  [[nodiscard]] std::vector<CellIndex> group(const CellIndex& start) {
    std::vector<CellIndex> cells;
    visit(start, cells);
    for (std::size_t next = 0; next < cells.size(); ++next) {
      const CellIndex cell = cells[next];
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) visit({cell.ix + dx, cell.iy + dy}, cells);
    }
    return cells;
  }

 private:
  void visit(const CellIndex& cell, std::vector<CellIndex>& cells) {
    if (!window_.contains(cell.ix, cell.iy) || !map_.is_obstacle(cell.ix, cell.iy)) return;
    auto& seen = seen_[static_cast<std::size_t>(cell.iy - window_.y0) *
                           static_cast<std::size_t>(window_.width()) +
                       static_cast<std::size_t>(cell.ix - window_.x0)];
    if (std::exchange(seen, std::uint8_t{1}) == 0) cells.push_back(cell);
  }

  const StaticMap& map_;
  CellRect window_;
  std::vector<std::uint8_t> seen_;
};

CellRect intersect(const CellRect& a, const CellRect& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

bool fits(const std::vector<CellIndex>& cells, int whole) {
  const auto [left, right] = std::minmax_element(
      cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.ix < b.ix; });
  const auto [low, high] = std::minmax_element(
      cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.iy < b.iy; });
  return right->ix - left->ix < whole && high->iy - low->iy < whole;
}

CellIndex lowest(const std::vector<CellIndex>& cells) {
  return *std::min_element(cells.begin(), cells.end(), [](const auto& a, const auto& b) {
    return a.iy != b.iy ? a.iy < b.iy : a.ix < b.ix;
  });
}

}  // namespace

std::vector<std::vector<CellIndex>> clusters_of_tile(const StaticMap& map, const CellRect& tile,
                                                     int whole) {
  // A group that meets the tile lies either entirely within this window or is larger than `whole`.
  const CellRect grid{0, 0, map.grid().width, map.grid().height};
  const CellRect window =
      intersect({tile.x0 - whole, tile.y0 - whole, tile.x1 + whole, tile.y1 + whole}, grid);
  const CellRect own = intersect(tile, grid);
  Flood near(map, window), within(map, own);
  std::vector<std::vector<CellIndex>> clusters;
  std::vector<CellIndex> cut;
  for (int iy = own.y0; iy < own.y1; ++iy)
    for (int ix = own.x0; ix < own.x1; ++ix) {
      if (!map.is_obstacle(ix, iy)) continue;
      auto group = near.group({ix, iy});
      if (group.empty()) continue;
      if (fits(group, whole)) {
        const CellIndex first = lowest(group);
        if (own.contains(first.ix, first.iy)) clusters.push_back(std::move(group));
        continue;
      }
      std::erase_if(group, [&](const auto& cell) { return !own.contains(cell.ix, cell.iy); });
      cut.insert(cut.end(), group.begin(), group.end());
    }
  for (const CellIndex& cell : cut)
    if (auto piece = within.group(cell); !piece.empty()) clusters.push_back(std::move(piece));
  return clusters;
}

}  // namespace tandem
