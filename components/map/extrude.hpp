// SPDX-License-Identifier: Apache-2.0
// Makes an OctoMap of a plane: walls of one height on a floor at z = 0.
#pragma once

#include <octomap/OcTree.h>

#include <memory>

#include "tandem/map/grid.hpp"

namespace tandem {

/// Every occupied cell becomes a column of occupied voxels from z = 0 to `height` [m], and every
/// free cell one of free voxels; unknown cells stay unknown. If the cells are not aligned with
/// OctoMap's voxels, a voxel is occupied if it overlaps an occupied cell, else free if it overlaps
/// a free one. Memory grows with the outlines in the plane, not with its area. Throws
/// std::runtime_error if the plane lies beyond OctoMap's range or contains no known cell.
[[nodiscard]] std::unique_ptr<octomap::OcTree> extrude(const Grid& grid, double height);

}  // namespace tandem
