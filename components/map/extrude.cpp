// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/extrude.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tandem/map/detail/octree_keys.hpp"
#include "tandem/map/overlay.hpp"

namespace tandem {
namespace {

constexpr double kAligned = 1e-3;  // of a cell; smaller offsets count as aligned

// Contents of a square of voxels.
enum class Square : std::uint8_t { kFree, kOccupied, kUnknown, kMixed };

// Squares of 2^level voxels; (x, y) is the first, in units of their size.
struct Level {
  int x = 0, y = 0, width = 0, height = 0;
  std::vector<Square> squares;

  [[nodiscard]] Square at(int ix, int iy) const {
    if (ix < x || iy < y || ix >= x + width || iy >= y + height) return Square::kUnknown;
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
  std::transform(grid.cells.begin(), grid.cells.end(), level.squares.begin(),
                 [](Cell cell) { return static_cast<Square>(cell); });
  return level;
}

Square together(const Level& fine, int x, int y) {
  const Square first = fine.at(x, y);
  const bool same =
      fine.at(x + 1, y) == first && fine.at(x, y + 1) == first && fine.at(x + 1, y + 1) == first;
  return same ? first : Square::kMixed;
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

// Writes the tree in the format of a .bt file: for each inner node two bits per child, then its
// inner children one by one.
class TreeWriter {
 public:
  TreeWriter(Level voxels, int layers) : layers_{layers} {
    levels_.push_back(std::move(voxels));
    while (levels_.size() <= kTreeDepth) levels_.push_back(coarser(levels_.back()));
  }

  [[nodiscard]] std::string bytes() {
    write(kTreeDepth, {0, 0, 0});
    return std::move(out_);
  }

 private:
  using Cube = std::array<int, 3>;  // position, in cubes of its own size
  static constexpr unsigned kNone = 0, kFree = 1, kOccupied = 2, kInner = 3;  // kind of a child

  [[nodiscard]] unsigned kind(int level, const Cube& cube) const {
    const int low = cube[2] << level, high = low + (1 << level);
    const Square square = levels_[static_cast<std::size_t>(level)].at(cube[0], cube[1]);
    if (square == Square::kUnknown || high <= kMiddleKey || low >= kMiddleKey + layers_)
      return kNone;
    const bool is_whole = low >= kMiddleKey && high <= kMiddleKey + layers_;
    if (square == Square::kMixed || !is_whole) return kInner;
    return square == Square::kOccupied ? kOccupied : kFree;
  }

  static Cube child_of(const Cube& cube, int i) {
    return {2 * cube[0] + (i & 1), 2 * cube[1] + (i >> 1 & 1), 2 * cube[2] + (i >> 2)};
  }

  void write(int level, const Cube& cube) {
    std::array<unsigned, 8> kinds{};
    unsigned record = 0;
    for (int i = 0; i < 8; ++i) {
      kinds[static_cast<std::size_t>(i)] = kind(level - 1, child_of(cube, i));
      record |= kinds[static_cast<std::size_t>(i)] << (2 * i);
    }
    out_ += static_cast<char>(record & 0xffU);
    out_ += static_cast<char>(record >> 8U);
    for (int i = 0; i < 8; ++i)
      if (kinds[static_cast<std::size_t>(i)] == kInner) write(level - 1, child_of(cube, i));
  }

  int layers_;
  std::vector<Level> levels_;
  std::string out_;
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
  std::istringstream stream{TreeWriter{voxels_of(on_voxels(grid)), layers}.bytes()};
  auto tree = std::make_unique<octomap::OcTree>(grid.resolution);
  tree->readBinaryData(stream);
  return tree;
}

}  // namespace tandem
