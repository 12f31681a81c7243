// SPDX-License-Identifier: Apache-2.0
// Computes where a disc of the narrowest passable width fits, and which of these places are
// connected.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tandem/map/static_map.hpp"

namespace tandem {

/// Index of a cell in its grid.
struct CellIndex {
  int ix = 0, iy = 0;  ///< column and row

  bool operator==(const CellIndex&) const = default;
};

/// Cells [x0, x1) × [y0, y1) of a grid; may reach beyond it.
struct CellRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< first cell, and one past the last

  /// Cells along x.
  [[nodiscard]] int width() const { return x1 - x0; }
  /// Cells along y.
  [[nodiscard]] int height() const { return y1 - y0; }
  /// Number of cells.
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
  }
  /// Whether cell (ix, iy) is inside.
  [[nodiscard]] bool contains(int ix, int iy) const {
    return ix >= x0 && iy >= y0 && ix < x1 && iy < y1;
  }
  /// Row-major index of a contained cell.
  [[nodiscard]] std::size_t index(int ix, int iy) const {
    return static_cast<std::size_t>(iy - y0) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(ix - x0);
  }
};

/// Free cells where the centre of a disc of diameter `smallest_gap` can be without contact
/// ("places"), grouped into connected regions. If the map has free cells, only these are free;
/// otherwise every cell that is not an obstacle is. Regions too small to drive in are discarded.
class FreeRegions {
 public:
  /// Throws std::invalid_argument if the gap is negative or not finite.
  FreeRegions(const StaticMap& map, double smallest_gap);

  /// The cell's region, from 1; 0: the disc does not fit there.
  [[nodiscard]] int region(int ix, int iy) const {
    return area_.contains(ix, iy) ? regions_[area_.index(ix, iy)] : 0;
  }
  /// Distance from the cell's centre to the nearest cell that is not free, in cells, exact up to
  /// radius() + kBeyond; 0 outside the known area.
  [[nodiscard]] float gap(int ix, int iy) const {
    return area_.contains(ix, iy) ? gaps_[area_.index(ix, iy)] : 0.0F;
  }
  /// Whether the region has a place within kBeside of the point.
  [[nodiscard]] bool is_beside(const Eigen::Vector2d& p_MQ, int region) const;
  /// Region of the place nearest to the point; 0 if none is within kBeside.
  [[nodiscard]] int region_at(const Eigen::Vector2d& p_MQ) const;
  /// Radius of the disc, in cells.
  [[nodiscard]] double radius() const { return radius_; }

  static constexpr double kBeside = 0.5;  ///< [m]
  static constexpr int kBeyond = 4;       ///< [cells] to which gap() is exact beyond radius()

 private:
  void label_regions();
  [[nodiscard]] std::vector<std::size_t> spread(std::size_t start, int region);
  template <class Visit>
  void for_cells_beside(const Eigen::Vector2d& p_MQ, const Visit& visit) const;

  Eigen::Vector2d origin_;
  double resolution_;
  double radius_;
  CellRect area_;
  std::vector<float> gaps_;
  std::vector<std::int32_t> regions_;
};

}  // namespace tandem
