// SPDX-License-Identifier: Apache-2.0
// In: what somebody drew on a map that is not there: regions that are forbidden, lines that guide.
// Out: the same, and a grid in which the regions stand.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/guidance_line.hpp"

namespace tandem {

/// Part of the plane where the robot must not go although nothing stands there: a stairhead, a
/// therapy mat. Corners in M [m], in either order, the last joined to the first.
struct ForbiddenRegion {
  std::string name;
  std::vector<Eigen::Vector2d> p_MV;
};

/// Virtual fixtures (Rosenberg 1993; Devalla 2020, 2.1.1).
struct VirtualFixtures {
  std::vector<ForbiddenRegion> forbidden;
  std::vector<GuidanceLine> guidance;
};

/// Reads
///
///     forbidden:
///       - {name: stairs, polygon: [[x, y], [x, y], [x, y]]}
///     guidance:
///       - {name: lane, line: [[x, y], [x, y]], reach: 0.5, strength: 0.5}
///
/// in metres in the map frame; either list may be absent, reach and strength too. Throws
/// std::invalid_argument naming the file, the line and what is wrong there; an unknown key is
/// wrong.
[[nodiscard]] VirtualFixtures load_virtual_fixtures(const std::filesystem::path& file);

/// The grid with every cell occupied that a forbidden region reaches into (and some whose square
/// it misses by less than half a diagonal). Grows, by unknown cells, to hold the regions whole.
/// Throws std::runtime_error if it would have more than 10⁸ cells.
[[nodiscard]] Grid with_forbidden(Grid grid, const VirtualFixtures& fixtures);

}  // namespace tandem
