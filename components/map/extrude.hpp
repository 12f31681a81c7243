// SPDX-License-Identifier: Apache-2.0
// Makes an OctoMap of a plane: walls of one height on a floor at z = 0.
#pragma once

#include <octomap/OcTree.h>

#include <memory>

#include "tandem/map/grid.hpp"

namespace tandem {

/// Every occupied cell becomes a column of occupied voxels from z = 0 to `height` [m], a free one
/// of free voxels; unknown cells stay unknown. Where cells do not lie as OctoMap's voxels do, a
/// voxel is occupied if it overlaps an occupied cell, else free if it overlaps a free one. Costs
/// memory by the outlines in the plane, not by its area. Throws std::runtime_error if the plane is
/// farther from the origin than an OctoMap reaches or nothing in it is known.
[[nodiscard]] std::unique_ptr<octomap::OcTree> extrude(const Grid& grid, double height);

}  // namespace tandem
