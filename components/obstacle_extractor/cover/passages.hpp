// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. Finds the passages that coarser shapes have closed.
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

/// Passages for a disc of the robot's width between the free places of a window, past shapes that
/// cover some of its obstacles.
class Passages {
 public:
  /// `region`: the free region that the robot can reach; 0: all. `width`: of the robot [m].
  /// `clusters`: the cells that the shapes cover; all other cells that are not free stay as they
  /// are. `map` must outlive this.
  Passages(const StaticMap& map, const FreeRegions& places, const CellRect& window, int region,
           double width, const std::vector<std::vector<CellIndex>>& clusters);

  /// The cells that were examined.
  [[nodiscard]] const CellRect& window() const { return window_; }

  /// The cells (by CellRect::index) swept in passages that are open between the `fine` shapes for a
  /// disc with 7.5 cm to spare on either side, but closed between the `coarse` ones for a disc with
  /// 4.5 cm to spare; empty if there are none. Only passages between pieces of free space of more
  /// than 0.1 m² count.
  [[nodiscard]] std::vector<std::uint8_t> closed(const std::vector<Obstacle>& fine,
                                                 const std::vector<Obstacle>& coarse) const;

 private:
  using Labels = std::vector<int>;  // connected part of each cell of the window, from 1; 0: none

  [[nodiscard]] Labels parts(const std::vector<Obstacle>& shapes,
                             const std::vector<float>& to_others, double spare) const;
  [[nodiscard]] std::vector<float> distances_to(const std::vector<std::uint8_t>& mask) const;
  [[nodiscard]] std::vector<std::uint8_t> covered(const std::vector<Obstacle>& shapes) const;
  [[nodiscard]] std::vector<std::uint8_t> swept(const std::vector<std::uint8_t>& way) const;

  const Grid& grid_;
  double radius_;  // of the disc, in cells
  CellRect window_;
  std::vector<std::uint8_t> is_place_;
  std::vector<std::uint8_t> others_;  // cells that are not free and not in the clusters
};

}  // namespace tandem
