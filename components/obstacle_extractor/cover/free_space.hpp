// SPDX-License-Identifier: Apache-2.0
// In: a window of the map. Out: which of its free space a robot can use, and what a shape takes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

/// How deep a shape may reach into free space [m]: where there is room, where a way is narrow, and
/// at most in a narrow way that is kept open.
struct Excess {
  double open, narrow, kept;
};

/// What a robot can use of a window: not the obstacles, not narrow slots and corners, not pockets
/// without a way out, nor unknown space.
class FreeSpace {
 public:
  static constexpr double kAll = 1e9;  ///< [m²] more than any shape takes

  /// `region`: the places the robot can go to; 0: all.
  FreeSpace(const StaticMap& map, const FreeRegions& places, const CellRect& window, int region);

  /// Distance from the point to the nearest place that no disc at any of the map's places
  /// reaches [m], linear between cell centres; 0 there.
  [[nodiscard]] double depth(const Eigen::Vector2d& p_MQ) const;

  /// Whether a shape may contain the point: it lies no deeper than that.
  [[nodiscard]] bool allows(const Eigen::Vector2d& p_MQ, const Excess& most) const;

  /// Keeps narrow ways open from now on, where they lead through these cells (by CellRect::index).
  /// False if there are none, or if that was so already.
  [[nodiscard]] bool keep(const CellRect& window, const std::vector<std::uint8_t>& cells);

  /// Area of the region's places that the shape takes [m²]: those where the disc touches it. What
  /// is more than `most` may be told too small, but not as small as that.
  [[nodiscard]] double taken_by(const Obstacle& shape, double most = kAll) const;

  /// Whether the box lies in the window: only there is the space known.
  [[nodiscard]] bool knows(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;

 private:
  void find_useless();
  [[nodiscard]] bool is_useless(const Eigen::Vector2d& p_MQ) const;
  void find_passages(const std::vector<std::uint8_t>& places);
  void sum_up(const FreeRegions& places, const std::vector<std::uint8_t>& own);
  [[nodiscard]] double gap_at(const FreeRegions& places, int x, int y) const;

  double resolution_;
  double radius_;                 // of the disc, in cells
  CellRect window_;               // with a border, so that gaps at its edge are judged whole
  Eigen::Vector2d first_center_;  // of the window's lowest cell [m]
  Eigen::Vector2d low_, high_;    // of the window without the border [m]
  std::vector<float> depth_;
  std::vector<std::uint8_t> useless_;  // by the cell at its lower left: depth 0
  enum class Room : std::uint8_t { kOpen, kNarrow, kKept };
  std::vector<Room> room_;

  // The places again at `fine_` points per cell and axis: a shape's bulge is less than a cell.
  int fine_;
  Eigen::Vector2d first_point_;  // [m]
  std::vector<float> sums_;      // of the places, from the left of each row
};

}  // namespace tandem
