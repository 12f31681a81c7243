// SPDX-License-Identifier: Apache-2.0
// Builds a pruned OctoMap top-down, without visiting each voxel of a uniform region.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

#include <octomap/OcTree.h>

namespace tandem {

/// Contents of a cube of voxels. The values are those of a child in a .bt file.
enum class Cube : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2, kMixed = 3 };

/// Position of a cube, in cubes of its own size; (0, 0, 0) holds the voxel with key (0, 0, 0).
using CubeIndex = std::array<int, 3>;

/// Contents of a cube of 2^level voxels a side; level 0 is never kMixed.
using CubeContents = std::function<Cube(int level, const CubeIndex& index)>;

/// The tree with these contents, its free and occupied leaves at the clamping thresholds as in a
/// .bt file; empty if no voxel is known.
[[nodiscard]] std::unique_ptr<octomap::OcTree> octree_of_cubes(double resolution,
                                                               const CubeContents& contents);

}  // namespace tandem
