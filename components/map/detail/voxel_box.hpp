// SPDX-License-Identifier: Apache-2.0
// A dense box of voxels from which an OctoMap is built.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "tandem/map/detail/octree_of_cubes.hpp"

namespace tandem {

/// Voxels, or cubes of them, with the indices `low` to `low + size − 1`. Those outside are unknown.
class VoxelBox {
 public:
  VoxelBox(const CubeIndex& low, const CubeIndex& size);

  [[nodiscard]] Cube at(const CubeIndex& index) const {
    std::size_t i = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int offset = index[axis] - low_[axis];
      if (offset < 0 || offset >= size_[axis]) return Cube::kUnknown;
      i = i * static_cast<std::size_t>(size_[axis]) + static_cast<std::size_t>(offset);
    }
    return cubes_[i];
  }

  /// Sets the voxels (x, y, z_begin) to (x, y, z_end − 1), which must lie in the box.
  void set_column(int x, int y, int z_begin, int z_end, Cube contents);

  /// The same box in cubes of twice the size.
  [[nodiscard]] VoxelBox coarser() const;

 private:
  CubeIndex low_, size_;
  std::vector<Cube> cubes_;  // z varies fastest
};

/// The pruned tree of the voxels, empty if none is known. Indices are OctoMap's keys.
[[nodiscard]] std::unique_ptr<octomap::OcTree> octree_of(VoxelBox voxels, double resolution);

}  // namespace tandem
