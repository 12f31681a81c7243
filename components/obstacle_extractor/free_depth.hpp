// SPDX-License-Identifier: Apache-2.0
// In: a window of the map. Out: how deep a point lies in the space that a robot could use.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "map/static_map.hpp"

namespace tandem {

/// Cells [x0, x1) × [y0, y1) of a grid; may reach beyond it.
struct CellRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  [[nodiscard]] int width() const { return x1 - x0; }
  [[nodiscard]] int height() const { return y1 - y0; }
  [[nodiscard]] bool contains(int ix, int iy) const {
    return ix >= x0 && iy >= y0 && ix < x1 && iy < y1;
  }
};

struct FreeDepthParams {
  double smallest_gap = 0.40;    ///< space that no disc of this diameter reaches is of no use [m]
  bool unknown_is_free = false;  ///< whether unknown cells are of use
};

/// What a shape takes from the robot where it covers more than its cells: nothing in obstacles,
/// in narrow slots and (by choice) in unknown space; elsewhere the depth of the point.
class FreeDepth {
 public:
  FreeDepth(const StaticMap& map, const CellRect& window, const FreeDepthParams& params);

  /// Distance from the point to the nearest place that is of no use [m], linear between cell
  /// centres; 0 there.
  [[nodiscard]] double at(const Eigen::Vector2d& p_MQ) const;

  /// Whether the box lies in the window: only there is the depth known.
  [[nodiscard]] bool knows(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;

 private:
  double resolution_;
  CellRect window_;               // with a border, so that gaps at its edge are judged whole
  Eigen::Vector2d first_center_;  // of the window's lowest cell [m]
  Eigen::Vector2d low_, high_;    // of the window without the border [m]
  std::vector<float> depth_;
};

}  // namespace tandem
