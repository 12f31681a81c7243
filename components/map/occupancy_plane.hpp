// SPDX-License-Identifier: Apache-2.0
// Converts a nav_msgs/OccupancyGrid or a Nav2 map into a grid of the map frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Cells with their occupancy in percent, in a frame O whose origin is the outer corner of the
/// first cell. Rows run along O's x axis, starting at y = 0.
struct OccupancyPlane {
  Pose2 X_MO;                        ///< pose of the plane's corner
  double resolution = 0.05;          ///< [m]
  int width = 0, height = 0;         ///< cells along the plane's x and y
  std::vector<std::int8_t> percent;  ///< outside [0, 100]: unknown
};

/// The first error of the plane: its sizes contradict each other, it has more than kMaxCells
/// cells, a number is not finite or out of range, or no cell is occupied. Empty if there is none.
[[nodiscard]] std::string error_of(const OccupancyPlane& plane);

/// Cells of 50 % and more are occupied, as in OctoMap, those below are free. A rotated plane is
/// resampled to cells along the axes of M: occupied if they overlap an occupied cell, else as the
/// cell at their centre. Throws std::runtime_error with error_of, or if the result has more than
/// kMaxCells.
[[nodiscard]] Grid to_grid(const OccupancyPlane& plane);

}  // namespace tandem
