// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/extractor.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "tandem/obstacle_extractor/cover/clusters.hpp"

namespace tandem {
namespace {

constexpr double kWhole = 1.0;  // [m] clusters up to this size are never split at a tile border

// Maximum reach of a shape into a narrow passage [m]: in general, so that doors stay open, and in
// crowded tiles, in passages that coarser shapes would close.
constexpr double kNarrow = 0.05, kKept = 0.10;

constexpr double kHalfRate = 1.0;  // [m] from the robot, at which a tile is refitted half as often
constexpr std::size_t kPatches = 6;    // with more strips of new cells the tile is refitted at once
constexpr double kWider = 1.0 + 1e-9;  // margin so that rounding leaves no corner outside
constexpr double kOffRaster = 1e-3;    // [cells] maximum offset of two grids that share a raster

int cells(double length, const Grid& grid) {
  return std::max(1, static_cast<int>(std::ceil(length / grid.resolution - 1e-9)));
}

// Whether the whole square lies in the shape.
bool covers(const Obstacle& shape, const Eigen::Vector2d& p_MC, double half) {
  for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}})
    if (!contains(shape, p_MC + Eigen::Vector2d{x, y})) return false;
  return true;
}

// The cells as strips one cell wide along `along`.
std::vector<CellRect> strips_along(std::vector<CellIndex> cells, int CellIndex::*along,
                                   int CellIndex::*across) {
  std::sort(cells.begin(), cells.end(), [&](const CellIndex& a, const CellIndex& b) {
    return a.*across != b.*across ? a.*across < b.*across : a.*along < b.*along;
  });
  std::vector<CellRect> strips;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const CellIndex& cell = cells[i];
    const bool goes_on =
        i > 0 && cells[i - 1].*across == cell.*across && cells[i - 1].*along + 1 == cell.*along;
    if (!goes_on) strips.push_back({cell.ix, cell.iy, 0, 0});
    strips.back().x1 = cell.ix + 1;
    strips.back().y1 = cell.iy + 1;
  }
  return strips;
}

// The cells as strips along x or along y, whichever are fewer.
std::vector<CellRect> strips_of(const std::vector<CellIndex>& cells) {
  auto rows = strips_along(cells, &CellIndex::ix, &CellIndex::iy);
  auto columns = strips_along(cells, &CellIndex::iy, &CellIndex::ix);
  return rows.size() <= columns.size() ? rows : columns;
}

const ExtractorParams& checked(const ExtractorParams& params) {
  check(params);
  if (!(params.width > 0.0 && std::isfinite(params.width)))
    throw std::invalid_argument("width of the robot must be finite and above 0");
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
  const CellRect tiles = tiles_near(p_MB, range);
  for (int ty = tiles.y0; ty < tiles.y1; ++ty)
    for (int tx = tiles.x0; tx < tiles.x1; ++tx)
      for (const CoverShape& shape : tile_at(tx, ty).shapes)
        if (distance_to_cells(shape, p_MB) <= range) shapes.push_back(shape);
  return shapes;
}

void Extractor::update(std::shared_ptr<const StaticMap> map) {
  const Eigen::Vector2d moved = (map->grid().origin - map_->grid().origin) / map->grid().resolution;
  const bool is_same_raster = map->grid().resolution == map_->grid().resolution &&
                              (moved - moved.array().round().matrix()).norm() < kOffRaster;
  if (!is_same_raster) tiles_.clear();
  std::erase_if(tiles_, [&](const auto& tile) { return tile.second.map != updates_; });
  shift_ += moved.array().round().matrix().cast<int>();
  ++updates_;
  region_ = 0;
  map_ = std::move(map);
  places_ = FreeRegions{*map_, params_.smallest_gap};
}

bool Extractor::refresh_near(const Eigen::Vector2d& p_MB, double range, long settle) {
  if (!p_MB.allFinite()) return false;
  const CellRect rect = tiles_near(p_MB, range);
  auto oldest = tiles_.end();
  for (auto it = tiles_.begin(); it != tiles_.end(); ++it) {
    const auto& [place, tile] = *it;
    if (!tile.is_stale || !rect.contains(place[0], place[1])) continue;
    const double wait =
        static_cast<double>(settle) * (1.0 + distance_to_tile(place, p_MB) / kHalfRate);
    if (static_cast<double>(updates_ - tile.fitted) < wait) continue;
    if (oldest == tiles_.end() || tile.fitted < oldest->second.fitted) oldest = it;
  }
  if (oldest == tiles_.end()) return false;
  fit(oldest->second, oldest->first[0], oldest->first[1]);
  return true;
}

CellRect Extractor::tiles_near(const Eigen::Vector2d& p_MB, double range) const {
  const Grid& grid = map_->grid();
  const double side = cells(params_.tile, grid);
  // A cluster that is not split may extend into the tiles above, left and right of its own.
  const double reach = range + kWhole + grid.resolution;
  const auto clip = [](double cell, int size) {
    return std::clamp(std::floor(cell), -1.0, static_cast<double>(size));
  };
  const auto tile = [&](double cell, int shift) {
    return static_cast<int>(std::floor((cell + shift) / side));
  };
  const Eigen::Vector2d low = (p_MB - grid.origin).array() - reach;
  const Eigen::Vector2d high = (p_MB - grid.origin).array() + reach;
  const double x0 = clip(low.x() / grid.resolution, grid.width);
  const double y0 = clip(low.y() / grid.resolution, grid.height);
  const double x1 = clip(high.x() / grid.resolution, grid.width);
  const double y1 = clip(high.y() / grid.resolution, grid.height);
  if (x1 < 0.0 || y1 < 0.0 || x0 >= grid.width || y0 >= grid.height) return {};
  return {tile(std::max(0.0, x0), shift_.x()), tile(std::max(0.0, y0), shift_.y()),
          tile(std::min(x1, grid.width - 1.0), shift_.x()) + 1,
          tile(std::min(y1, grid.height - 1.0), shift_.y()) + 1};
}

double Extractor::distance_to_tile(const std::array<int, 2>& place,
                                   const Eigen::Vector2d& p_MB) const {
  const Grid& grid = map_->grid();
  const CellRect rect = cells_of(place[0], place[1]);
  const Eigen::Vector2d low = grid.origin + grid.resolution * Eigen::Vector2d(rect.x0, rect.y0);
  const Eigen::Vector2d high = grid.origin + grid.resolution * Eigen::Vector2d(rect.x1, rect.y1);
  return (p_MB - p_MB.cwiseMax(low).cwiseMin(high)).norm();
}

CellRect Extractor::cells_of(int tx, int ty) const {
  const int side = cells(params_.tile, map_->grid());
  const int x0 = tx * side - shift_.x(), y0 = ty * side - shift_.y();
  return {x0, y0, x0 + side, y0 + side};
}

void Extractor::enter_region(const Eigen::Vector2d& p_MB) {
  if (region_ != 0 && places_.is_beside(p_MB, region_)) return;
  const int region = places_.region_at(p_MB);
  if (region != 0) region_ = region;
}

const Extractor::Tile& Extractor::tile_at(int tx, int ty) {
  Tile& tile = tiles_[{tx, ty}];
  if (tile.map == updates_ && tile.region == region_) return tile;
  const bool is_new_map = tile.map != updates_, is_first = tile.map == 0;
  tile.map = updates_;
  tile.region = region_;
  const CellRect rect = cells_of(tx, ty);
  auto clusters = clusters_of_tile(*map_, rect, cells(kWhole, map_->grid()));
  for (auto& cluster : clusters)
    for (CellIndex& cell : cluster) cell = {cell.ix + shift_.x(), cell.iy + shift_.y()};
  const bool same_cells = clusters == std::exchange(tile.clusters, clusters);
  if (same_cells && clusters.empty()) return tile;
  const bool is_stale = tile.is_stale || !same_cells || space_round(rect) != tile.space;
  if (!is_first && is_new_map && patch(tile))
    tile.is_stale = is_stale;
  else if (is_stale || is_first)
    fit(tile, tx, ty);
  return tile;
}

// Keeps the shapes that still have cells and covers new cells by up to kPatches strips. Returns
// false if that does not cover all cells.
bool Extractor::patch(Tile& tile) const {
  std::vector<CellIndex> cells;
  for (const auto& cluster : tile.clusters)
    for (const CellIndex& cell : cluster)
      cells.push_back({cell.ix - shift_.x(), cell.iy - shift_.y()});
  const Grid& grid = map_->grid();
  const auto center = [&](const CellIndex& cell) { return grid.center(cell.ix, cell.iy); };
  std::erase_if(tile.shapes, [&](const CoverShape& shape) {
    return std::none_of(cells.begin(), cells.end(), [&](const CellIndex& cell) {
      return distance_to_cells(shape, center(cell)) <= 0.0;
    });
  });
  std::erase_if(cells, [&](const CellIndex& cell) {
    return std::any_of(tile.shapes.begin(), tile.shapes.end(), [&](const CoverShape& shape) {
      return distance_to_cells(shape, center(cell)) <= grid.resolution &&
             covers(shape.obstacle, center(cell), 0.5 * grid.resolution);
    });
  });
  const std::vector<CellRect> strips = strips_of(cells);
  if (strips.size() > kPatches) return false;
  for (const CellRect& strip : strips) tile.shapes.push_back(shape_of(strip));
  return true;
}

// A rectangle around the cells.
CoverShape Extractor::shape_of(const CellRect& cells) const {
  const Grid& grid = map_->grid();
  const Eigen::Vector2d low = grid.origin + grid.resolution * Eigen::Vector2d(cells.x0, cells.y0);
  const Eigen::Vector2d high = grid.origin + grid.resolution * Eigen::Vector2d(cells.x1, cells.y1);
  const Eigen::Vector2d half = 0.5 * kWider * (high - low), p_MO = 0.5 * (low + high);
  const bool is_upright = half.y() > half.x();
  return {Obstacle{.id = id_of({cells.x0 + shift_.x(), cells.y0 + shift_.y()}, p_MO),
                   .p_MO = p_MO,
                   .a = half.maxCoeff(),
                   .b = half.minCoeff(),
                   .angle = is_upright ? 0.5 * std::numbers::pi : 0.0,
                   .shape = ObstacleShape::kRectangle},
          low, high};
}

// FNV-1a hash of a shape's lowest cell, which is unique to it, and of its centre in half cells. The
// same shape has the same id in every map, and equal ids mean equal positions.
std::uint32_t Extractor::id_of(const CellIndex& lowest, const Eigen::Vector2d& p_MO) const {
  const Grid& grid = map_->grid();
  const Eigen::Vector2d halves =
      2.0 * ((p_MO - grid.origin) / grid.resolution + shift_.cast<double>());
  std::uint32_t hash = 0x811c9dc5U;
  for (const int number : {lowest.ix, lowest.iy, static_cast<int>(std::lround(halves.x())),
                           static_cast<int>(std::lround(halves.y()))})
    for (int byte = 0; byte < 32; byte += 8)
      hash = (hash ^ (static_cast<std::uint32_t>(number) >> byte & 0xFFU)) * 0x01000193U;
  return std::max(hash, 1U);
}

void Extractor::fit(Tile& tile, int tx, int ty) const {
  const Grid& grid = map_->grid();
  const CellRect rect = cells_of(tx, ty);
  tile.is_stale = false;
  tile.fitted = updates_;
  tile.shapes.clear();
  if (tile.clusters.empty()) return;
  auto clusters = tile.clusters;
  for (auto& cluster : clusters)
    for (CellIndex& cell : cluster) cell = {cell.ix - shift_.x(), cell.iy - shift_.y()};
  const int margin = 2 * cells(kWhole, grid);
  const CellRect window{rect.x0 - margin, rect.y0 - margin, rect.x1 + margin, rect.y1 + margin};
  const FreeSpace space(*map_, places_, window, region_, params_.max_excess);
  tile.space = space_round(rect);
  const Passages ways(*map_, places_, window, region_, params_.width, clusters);
  tile.shapes = cover(grid, clusters, space, ways,
                      {.excess = {params_.max_excess, std::min(kNarrow, params_.max_excess), kKept},
                       .space_per_shape = params_.space_per_shape,
                       .crowded = static_cast<std::size_t>(params_.shapes_per_tile)});
  for (CoverShape& shape : tile.shapes) {
    const auto index = static_cast<int>(shape.obstacle.id - 1);
    shape.obstacle.id = id_of({index % grid.width + shift_.x(), index / grid.width + shift_.y()},
                              shape.obstacle.p_MO);
  }
}

// FNV-1a hash of everything that FreeSpace reads of the free regions.
std::uint64_t Extractor::space_round(const CellRect& rect) const {
  const double radius = places_.radius();
  const int margin =
      2 * cells(kWhole, map_->grid()) + static_cast<int>(std::ceil(2.0 * radius)) + 3;
  const auto most = static_cast<float>(radius + 3.0);  // larger gaps make no difference
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (int iy = rect.y0 - margin; iy < rect.y1 + margin; ++iy)
    for (int ix = rect.x0 - margin; ix < rect.x1 + margin; ++ix) {
      const int region = places_.region(ix, iy);
      const std::uint32_t kind = region == 0 ? 0 : region_ == 0 || region == region_ ? 1 : 2;
      const auto gap = std::bit_cast<std::uint32_t>(std::min(places_.gap(ix, iy), most));
      hash = (hash ^ (std::uint64_t{kind} << 32U | gap)) * 0x100000001b3U;
    }
  return hash;
}

std::vector<Obstacle> extract(const StaticMap& map, const Eigen::Vector2d& p_MB,
                              const ExtractorParams& params) {
  // Non-owning pointer: `map` outlives the extractor.
  Extractor extractor(std::shared_ptr<const StaticMap>(std::shared_ptr<void>{}, &map), params);
  return extractor.near(p_MB);
}

}  // namespace tandem
