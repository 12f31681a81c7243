// SPDX-License-Identifier: Apache-2.0
// Groups the obstacle cells of the map into connected clusters and assigns each to one tile.
#pragma once

#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

/// The clusters that belong to `tile`: groups of obstacle cells connected by edges or corners. A
/// group of at most `whole` cells in either direction belongs entirely to the tile of its lowest,
/// leftmost cell, so that a pole on a tile border stays one cluster; a larger group is split at the
/// tile borders. Every obstacle cell of the map belongs to exactly one tile.
[[nodiscard]] std::vector<std::vector<CellIndex>> clusters_of_tile(const StaticMap& map,
                                                                   const CellRect& tile, int whole);

}  // namespace tandem
