// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tandem/map/distance_transform.hpp"
#include "tandem/obstacle_extractor/cover/flood_fill.hpp"

namespace tandem {
namespace {

constexpr double kPocket = 0.25;  // [m²] smaller regions are discarded as dead ends
constexpr double kAround = 3.0;   // [m] margin around the grid if unknown cells count as free

bool has_free_cell(const Grid& grid) {
  return std::find(grid.cells.begin(), grid.cells.end(), Cell::kFree) != grid.cells.end();
}

}  // namespace

FreeRegions::FreeRegions(const StaticMap& map, double smallest_gap)
    : origin_{map.grid().origin},
      resolution_{map.grid().resolution},
      radius_{0.5 * smallest_gap / resolution_} {
  if (!(smallest_gap >= 0.0) || !std::isfinite(smallest_gap))
    throw std::invalid_argument("smallest_gap must be finite and not negative");
  const Grid& grid = map.grid();
  const bool unknown_is_free = !has_free_cell(grid);
  const int around = unknown_is_free ? static_cast<int>(kAround / resolution_) : 0;
  area_ = {-around, -around, grid.width + around, grid.height + around};
  const std::uint8_t unknown = unknown_is_free && !map.is_obstacle(-1, -1) ? 0 : 1;
  std::vector<std::uint8_t> useless(area_.size(), unknown);
  const Cell* cell = grid.cells.data();
  for (int iy = 0; iy < grid.height; ++iy) {
    std::uint8_t* const row = useless.data() + area_.index(0, iy);
    for (int ix = 0; ix < grid.width; ++ix, ++cell)
      row[ix] = *cell == Cell::kFree ? 0 : *cell == Cell::kOccupied ? 1 : unknown;
  }
  gaps_ = distance_transform(useless, area_.width(), area_.height(),
                             static_cast<int>(std::ceil(radius_)) + kBeyond);
  regions_.reserve(useless.size());
  for (const float gap : gaps_)
    regions_.push_back(static_cast<double>(gap) >= std::max(0.5, radius_) ? -1 : 0);
  label_regions();
}

// -1 marks a place that has no region number yet.
void FreeRegions::label_regions() {
  const auto least = static_cast<std::size_t>(kPocket / (resolution_ * resolution_));
  int region = 1;
  for (std::size_t start = 0; start < regions_.size(); ++start) {
    if (regions_[start] != -1) continue;
    const auto cells = spread(start, region);
    if (cells.size() > least)
      ++region;
    else
      for (const std::size_t cell : cells) regions_[cell] = 0;
  }
}

std::vector<std::size_t> FreeRegions::spread(std::size_t start, int region) {
  std::vector<std::size_t> cells{start};
  regions_[start] = region;
  flood_fill(cells, static_cast<std::size_t>(area_.width()), regions_.size(),
             [&](std::size_t cell, std::size_t) {
               if (regions_[cell] != -1) return false;
               regions_[cell] = region;
               return true;
             });
  return cells;
}

template <class Visit>
void FreeRegions::for_cells_beside(const Eigen::Vector2d& p_MQ, const Visit& visit) const {
  const Eigen::Vector2d c = (p_MQ - origin_) / resolution_;
  const double reach = kBeside / resolution_;
  const auto clip = [](double value, int low, int high) {
    return static_cast<int>(std::clamp(std::floor(value), 1.0 * low, 1.0 * high));
  };
  for (int iy = clip(c.y() - reach, area_.y0, area_.y1);
       iy < clip(c.y() + reach + 1.0, area_.y0, area_.y1); ++iy)
    for (int ix = clip(c.x() - reach, area_.x0, area_.x1);
         ix < clip(c.x() + reach + 1.0, area_.x0, area_.x1); ++ix) {
      const double d = (Eigen::Vector2d{ix + 0.5, iy + 0.5} - c).norm();
      if (d <= reach) visit(regions_[area_.index(ix, iy)], d);
    }
}

bool FreeRegions::is_beside(const Eigen::Vector2d& p_MQ, int region) const {
  bool beside = false;
  for_cells_beside(p_MQ, [&](int other, double) { beside = beside || other == region; });
  return beside;
}

int FreeRegions::region_at(const Eigen::Vector2d& p_MQ) const {
  int nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for_cells_beside(p_MQ, [&](int region, double d) {
    if (region == 0 || d >= least) return;
    least = d;
    nearest = region;
  });
  return nearest;
}

}  // namespace tandem
