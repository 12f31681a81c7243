// SPDX-License-Identifier: Apache-2.0
// Turns a nav_msgs/OccupancyGrid or a Nav2 map into a grid of the map frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Cells with their occupancy in percent, in a frame O whose origin is the outer corner of the
/// first cell. Rows run along O's x axis, from y = 0 on.
struct OccupancyPlane {
  Pose2 X_MO;
  double resolution = 0.05;  ///< [m]
  int width = 0, height = 0;
  std::vector<std::int8_t> percent;  ///< outside of [0, 100]: unknown
};

/// What is wrong with it: its sizes contradict each other, it has more than kMostCells cells, a
/// number is not finite or out of range, nothing in it is occupied. Empty: nothing.
[[nodiscard]] std::string error_of(const OccupancyPlane& plane);

/// Cells of 50 % and more are occupied, as in OctoMap, those of less free. A plane that is turned
/// gives cells along the axes of M: occupied if they overlap an occupied cell, else as the cell at
/// their centre. Throws std::runtime_error with error_of, or if it were more than kMostCells.
[[nodiscard]] Grid to_grid(const OccupancyPlane& plane);

}  // namespace tandem
