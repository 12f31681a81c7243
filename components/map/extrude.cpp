// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/extrude.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tandem/map/detail/octree_keys.hpp"
#include "tandem/map/detail/octree_of_cubes.hpp"
#include "tandem/map/overlay.hpp"

namespace tandem {
namespace {

constexpr double kAligned = 1e-3;  // of a cell; smaller offsets count as aligned

// Squares of 2^level voxels; (x, y) is the first, in units of their size.
struct Level {
  int x = 0, y = 0, width = 0, height = 0;
  std::vector<Cube> squares;

  [[nodiscard]] Cube at(int ix, int iy) const {
    if (ix < x || iy < y || ix >= x + width || iy >= y + height) return Cube::kUnknown;
    return squares[static_cast<std::size_t>(iy - y) * static_cast<std::size_t>(width) +
                   static_cast<std::size_t>(ix - x)];
  }
};

Level voxels_of(const Grid& grid) {
  const auto key = [&](double low) {
    return static_cast<int>(std::lround(low / grid.resolution)) + kMiddleKey;
  };
  Level level{key(grid.origin.x()), key(grid.origin.y()), grid.width, grid.height, {}};
  level.squares.resize(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), level.squares.begin(), [](Cell cell) {
    if (cell == Cell::kUnknown) return Cube::kUnknown;
    return cell == Cell::kOccupied ? Cube::kOccupied : Cube::kFree;
  });
  return level;
}

Cube together(const Level& fine, int x, int y) {
  const Cube first = fine.at(x, y);
  const bool same =
      fine.at(x + 1, y) == first && fine.at(x, y + 1) == first && fine.at(x + 1, y + 1) == first;
  return same ? first : Cube::kMixed;
}

Level coarser(const Level& fine) {
  Level level{fine.x / 2, fine.y / 2, 0, 0, {}};
  level.width = (fine.x + fine.width - 1) / 2 - level.x + 1;
  level.height = (fine.y + fine.height - 1) / 2 - level.y + 1;
  level.squares.reserve(static_cast<std::size_t>(level.width) *
                        static_cast<std::size_t>(level.height));
  for (int y = level.y; y < level.y + level.height; ++y)
    for (int x = level.x; x < level.x + level.width; ++x)
      level.squares.push_back(together(fine, 2 * x, 2 * y));
  return level;
}

// A grid whose cells are columns of `layers` voxels above z = 0.
class Columns {
 public:
  Columns(Level voxels, int layers) : layers_{layers} {
    levels_.push_back(std::move(voxels));
    while (levels_.size() <= kTreeDepth) levels_.push_back(coarser(levels_.back()));
  }

  [[nodiscard]] Cube contents(int level, const CubeIndex& index) const {
    const int low = index[2] << level, high = low + (1 << level);
    const Cube square = levels_[static_cast<std::size_t>(level)].at(index[0], index[1]);
    if (square == Cube::kUnknown || high <= kMiddleKey || low >= kMiddleKey + layers_)
      return Cube::kUnknown;
    const bool is_whole = low >= kMiddleKey && high <= kMiddleKey + layers_;
    return is_whole ? square : Cube::kMixed;
  }

 private:
  int layers_;
  std::vector<Level> levels_;
};

// The grid resampled onto OctoMap's voxels.
Grid on_voxels(const Grid& grid) {
  const Eigen::Array2d low = grid.origin.array() / grid.resolution;
  if ((low - low.round()).abs().maxCoeff() < kAligned) return grid;
  Grid out{grid.resolution, low.floor() * grid.resolution, grid.width + 1, grid.height + 1, {}};
  out.cells.assign(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height),
                   Cell::kUnknown);
  lay_over(out, grid);
  return out;
}

}  // namespace

std::unique_ptr<octomap::OcTree> extrude(const Grid& grid, double height) {
  const Eigen::Array2d low = grid.origin.array() / grid.resolution;
  const Eigen::Array2d high = low + Eigen::Array2d{grid.width, grid.height};
  if (!(low.abs().max(high.abs()).maxCoeff() < kMiddleKey - 1.0))
    throw std::runtime_error(
        "the map extends farther from its origin than an OctoMap can represent (" +
        std::to_string(kMiddleKey * grid.resolution) +
        " m); move the origin or use a coarser resolution");
  if (std::all_of(grid.cells.begin(), grid.cells.end(),
                  [](Cell cell) { return cell == Cell::kUnknown; }))
    throw std::runtime_error("the map has no known cell");
  const int layers =
      std::clamp(static_cast<int>(std::lround(height / grid.resolution)), 1, kMiddleKey);
  const Columns columns{voxels_of(on_voxels(grid)), layers};
  return octree_of_cubes(grid.resolution, [&](int level, const CubeIndex& index) {
    return columns.contents(level, index);
  });
}

}  // namespace tandem
