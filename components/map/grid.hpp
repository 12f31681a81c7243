// SPDX-License-Identifier: Apache-2.0
// A plane of free, occupied and unknown cells in the map frame.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace tandem {

/// State of a cell of a grid.
enum class Cell : std::uint8_t { kFree, kOccupied, kUnknown };

/// Largest number of cells of a grid; larger requests are errors instead of exhausting memory.
inline constexpr std::int64_t kMaxCells = 100'000'000;

/// Row-major cells, row 0 at the lowest y. Cell (ix, iy) is the square of side `resolution` whose
/// lower left corner is origin + resolution · (ix, iy).
struct Grid {
  double resolution = 0.05;          ///< [m]
  Eigen::Vector2d origin{0.0, 0.0};  ///< lower left corner of cell (0, 0) in M [m]
  int width = 0, height = 0;         ///< cells along x and y
  std::vector<Cell> cells;           ///< width · height

  /// Whether the grid has a cell (ix, iy).
  [[nodiscard]] bool contains(int ix, int iy) const {
    return ix >= 0 && iy >= 0 && ix < width && iy < height;
  }
  /// Index in `cells` of a cell inside the grid.
  [[nodiscard]] std::size_t index(int ix, int iy) const {
    return static_cast<std::size_t>(iy) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(ix);
  }
  /// The cell (ix, iy), which the grid must contain.
  [[nodiscard]] Cell at(int ix, int iy) const { return cells[index(ix, iy)]; }
  /// Centre of a cell [m].
  [[nodiscard]] Eigen::Vector2d center(int ix, int iy) const {
    return {origin.x() + resolution * (ix + 0.5), origin.y() + resolution * (iy + 0.5)};
  }
};

}  // namespace tandem
