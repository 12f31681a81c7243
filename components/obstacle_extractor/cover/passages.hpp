// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. In: shapes before and after they got coarser. Out: the ways that
// this has closed.
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

/// Ways of a disc as wide as the robot between the places of a window, past shapes that cover some
/// of its obstacles.
class Passages {
 public:
  /// `region`: the places the robot can go to; 0: all. `width`: of the robot [m]. `clusters`: the
  /// cells that the shapes cover; what else is not free is as it is. `map` has to outlive this.
  Passages(const StaticMap& map, const FreeRegions& places, const CellRect& window, int region,
           double width, const std::vector<std::vector<CellIndex>>& clusters);

  [[nodiscard]] const CellRect& window() const { return window_; }

  /// Where a disc that is 7.5 cm wider on either side gets through between the `fine` shapes from
  /// one room to another, and one that is 4.5 cm wider does not any more between the `coarse` ones:
  /// the cells that it passes over, by CellRect::index; empty if there are none. A room is a piece
  /// of places of more than 0.1 m².
  [[nodiscard]] std::vector<std::uint8_t> closed(const std::vector<Obstacle>& fine,
                                                 const std::vector<Obstacle>& coarse) const;

 private:
  using Labels = std::vector<int>;  // of the window's cells: the connected part, from 1; 0: none

  [[nodiscard]] Labels parts(const std::vector<Obstacle>& shapes,
                             const std::vector<double>& to_others, double spare) const;
  [[nodiscard]] std::vector<std::uint8_t> covered(const std::vector<Obstacle>& shapes) const;
  [[nodiscard]] std::vector<std::uint8_t> swept(const std::vector<std::uint8_t>& way) const;

  const Grid& grid_;
  double radius_;  // of the disc, in cells
  CellRect window_;
  std::vector<std::uint8_t> is_place_;
  std::vector<std::uint8_t> others_;  // what is not free and no cell of the clusters
};

}  // namespace tandem
