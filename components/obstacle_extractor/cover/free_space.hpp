// SPDX-License-Identifier: Apache-2.0
// Computes which free space of a map window the robot can use, and how much of it a shape takes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

/// Maximum reach of a shape into free space [m]: in open space, in narrow passages, and in narrow
/// passages that must stay open.
struct Excess {
  double open, narrow, kept;  ///< [m]
};

/// The usable free space of a window. Excludes obstacles, narrow slots and corners, pockets without
/// an exit, and unknown space.
class FreeSpace {
 public:
  static constexpr double kAll = 1e9;  ///< [m²] larger than any shape's area

  /// `region`: the free region that the robot can reach; 0: all. `deepest`: the largest reach into
  /// free space that will be asked about [m].
  FreeSpace(const StaticMap& map, const FreeRegions& places, const CellRect& window, int region,
            double deepest);

  /// Depth of the point in the usable space: its distance to the nearest point that no disc at a
  /// place of the map reaches [m], interpolated linearly between cell centres; 0 outside the usable
  /// space. Somewhere above `deepest` where it is larger.
  [[nodiscard]] double depth(const Eigen::Vector2d& p_MQ) const;

  /// Whether a shape may contain the point: its depth is within the limit that applies there.
  [[nodiscard]] bool allows(const Eigen::Vector2d& p_MQ, const Excess& most) const;

  /// Marks the narrow passages through these cells (indexed by CellRect::index) as kept open. False
  /// if there are none, or if all of them were marked before.
  [[nodiscard]] bool keep(const CellRect& window, const std::vector<std::uint8_t>& cells);

  /// Area of the region's places that are lost to the shape [m²]: those where the disc would touch
  /// it. Exact up to `most`; a larger area may be underestimated, but the result stays above
  /// `most`.
  [[nodiscard]] double taken_by(const Obstacle& shape, double most = kAll) const;
  /// The same for a shape whose length lies along this unit vector.
  [[nodiscard]] double taken_by(const Obstacle& shape, const Eigen::Vector2d& along,
                                double most) const;

  /// Like taken_by for the convex hull of at least three points, counter-clockwise. A shape that
  /// contains it takes no less, up to the precision of both.
  [[nodiscard]] double taken_by(const std::vector<Eigen::Vector2d>& hull, double most = kAll) const;

  /// Whether the box lies in the window; outside of it the free space is not known.
  [[nodiscard]] bool is_known(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;

 private:
  template <class Dilated>
  [[nodiscard]] double area_of(const Dilated& shape, const Eigen::Vector2d& m, double most) const;
  void find_useless();
  [[nodiscard]] bool is_useless(const Eigen::Vector2d& p_MQ) const;
  void find_passages(const std::vector<std::uint8_t>& places);
  void sum_up(const FreeRegions& places, const std::vector<std::uint8_t>& own);

  double resolution_;
  double radius_;                 // of the disc, in cells
  CellRect window_;               // includes a border, so that gaps at the edge are complete
  Eigen::Vector2d first_center_;  // of the window's lowest cell [m]
  Eigen::Vector2d low_, high_;    // of the window without the border [m]
  std::vector<float> depth_;
  std::vector<std::uint8_t> useless_;  // 1: depth 0 in the square with this lower-left corner
  enum class Room : std::uint8_t { kOpen, kNarrow, kKept };
  std::vector<Room> room_;

  // The places sampled at `fine_` points per cell and axis, because a shape's bulge is smaller than
  // a cell.
  int fine_;
  Eigen::Vector2d first_point_;  // [m]
  std::vector<float> sums_;      // prefix sums along each row
};

}  // namespace tandem
