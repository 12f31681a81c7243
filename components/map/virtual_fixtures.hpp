// SPDX-License-Identifier: Apache-2.0
// Reads virtual fixtures (forbidden regions and guidance lines) and adds the regions to a grid.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/guidance_line.hpp"

namespace tandem {

/// Part of the plane that the robot must not enter although no obstacle is there: a stairhead, a
/// therapy mat. Corners in M [m], in either orientation; the last is joined to the first.
struct ForbiddenRegion {
  std::string name;                   ///< for messages
  std::vector<Eigen::Vector2d> p_MV;  ///< at least three [m]
};

/// Virtual fixtures (Rosenberg 1993; Devalla 2020, 2.1.1).
struct VirtualFixtures {
  std::vector<ForbiddenRegion> forbidden;  ///< regions that must not be entered
  std::vector<GuidanceLine> guidance;      ///< lines that attract
};

/// Reads
///
///     forbidden:
///       - {name: stairs, polygon: [[x, y], [x, y], [x, y]]}
///     guidance:
///       - {name: lane, line: [[x, y], [x, y]], reach: 0.5, strength: 0.5}
///
/// in metres in the map frame. Both lists, reach and strength are optional. Throws
/// std::invalid_argument naming the file, the line and the error; an unknown key is an error.
[[nodiscard]] VirtualFixtures load_virtual_fixtures(const std::filesystem::path& file);

/// The grid with every cell occupied that a forbidden region overlaps (and some that it misses by
/// less than half a cell's diagonal). Extends the grid with unknown cells to contain the regions
/// completely. Throws std::runtime_error if it would have more than 10⁸ cells.
[[nodiscard]] Grid with_forbidden(Grid grid, const VirtualFixtures& fixtures);

}  // namespace tandem
