// SPDX-License-Identifier: Apache-2.0
// In: a tile of the map. Out: the connected groups of obstacle cells that it answers for.
#pragma once

#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

/// Connected groups (edges or corners touch) of obstacle cells. A group no larger than `whole`
/// cells either way belongs whole to the tile of its lowest, leftmost cell, so that a pole on the
/// border of two tiles stays one; a larger one is cut along the tiles' borders. Together the tiles
/// of a map have every obstacle cell exactly once.
[[nodiscard]] std::vector<std::vector<CellIndex>> clusters_of_tile(const StaticMap& map,
                                                                   const CellRect& tile, int whole);

}  // namespace tandem
