// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/extractor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "obstacle_extractor/clusters.hpp"

namespace tandem {
namespace {

constexpr double kWhole = 1.0;  // [m] clusters up to this size are never cut by a tile's border

int cells(double length, const Grid& grid) {
  return std::max(1, static_cast<int>(std::ceil(length / grid.resolution - 1e-9)));
}

const ExtractorParams& checked(const ExtractorParams& params) {
  check(params);
  return params;
}

}  // namespace

Extractor::Extractor(std::shared_ptr<const StaticMap> map, const ExtractorParams& params)
    : map_{std::move(map)}, params_{params}, places_{*map_, checked(params).smallest_gap} {}

std::vector<Obstacle> Extractor::near(const Eigen::Vector2d& p_MB) {
  std::vector<Obstacle> obstacles;
  for (const CoverShape& shape : shapes_near(p_MB, params_.range))
    obstacles.push_back(shape.obstacle);
  return obstacles;
}

std::vector<CoverShape> Extractor::shapes_near(const Eigen::Vector2d& p_MB, double range) {
  std::vector<CoverShape> shapes;
  if (!p_MB.allFinite()) return shapes;
  enter_region(p_MB);
  const Grid& grid = map_->grid();
  const int side = cells(params_.tile, grid);
  // A whole cluster may reach from its tile into the next ones up, left and right.
  const double reach = range + kWhole + grid.resolution;
  const auto tile = [&](double metres, int tiles) {
    return static_cast<int>(std::clamp(std::floor(metres / (side * grid.resolution)), -1.0,
                                       static_cast<double>(tiles)));
  };
  const int columns = (grid.width + side - 1) / side, rows = (grid.height + side - 1) / side;
  const Eigen::Vector2d low = p_MB - grid.origin - Eigen::Vector2d::Constant(reach);
  const Eigen::Vector2d high = p_MB - grid.origin + Eigen::Vector2d::Constant(reach);
  for (int ty = std::max(0, tile(low.y(), rows)); ty <= std::min(rows - 1, tile(high.y(), rows));
       ++ty)
    for (int tx = std::max(0, tile(low.x(), columns));
         tx <= std::min(columns - 1, tile(high.x(), columns)); ++tx)
      for (const CoverShape& shape : tile_at(tx, ty))
        if (distance_to_cells(shape, p_MB) <= range) shapes.push_back(shape);
  return shapes;
}

void Extractor::enter_region(const Eigen::Vector2d& p_MB) {
  if (region_ != 0 && places_.is_beside(p_MB, region_)) return;
  const int region = places_.region_at(p_MB);
  if (region != 0) region_ = region;
}

const std::vector<CoverShape>& Extractor::tile_at(int tx, int ty) {
  const auto [entry, is_new] = tiles_.try_emplace({region_, tx, ty});
  if (!is_new) return entry->second;
  const Grid& grid = map_->grid();
  const int side = cells(params_.tile, grid), whole = cells(kWhole, grid);
  const CellRect tile{tx * side, ty * side, (tx + 1) * side, (ty + 1) * side};
  const auto clusters = clusters_of_tile(*map_, tile, whole);
  if (clusters.empty()) return entry->second;
  const int margin = 2 * whole;
  const FreeSpace space(*map_, places_,
                        {tile.x0 - margin, tile.y0 - margin, tile.x1 + margin, tile.y1 + margin},
                        region_);
  return entry->second =
             cover(grid, clusters, space,
                   {.max_excess = params_.max_excess, .space_per_shape = params_.space_per_shape});
}

std::vector<Obstacle> extract(const StaticMap& map, const Eigen::Vector2d& p_MB,
                              const ExtractorParams& params) {
  // The pointer does not own: the extractor ends before the map does.
  Extractor extractor(std::shared_ptr<const StaticMap>(std::shared_ptr<void>{}, &map), params);
  return extractor.near(p_MB);
}

}  // namespace tandem
