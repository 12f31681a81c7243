// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/detail/voxel_box.hpp"

#include <algorithm>
#include <utility>

#include "tandem/map/detail/octree_keys.hpp"

namespace tandem {
namespace {

std::size_t volume(const CubeIndex& size) {
  std::size_t product = 1;
  for (const int side : size) product *= static_cast<std::size_t>(side);
  return product;
}

}  // namespace

VoxelBox::VoxelBox(const CubeIndex& low, const CubeIndex& size)
    : low_{low}, size_{size}, cubes_(volume(size), Cube::kUnknown) {}

void VoxelBox::set_column(int x, int y, int z_begin, int z_end, Cube contents) {
  if (z_begin >= z_end) return;
  const CubeIndex at{x - low_[0], y - low_[1], z_begin - low_[2]};
  const std::ptrdiff_t first =
      (static_cast<std::ptrdiff_t>(at[0]) * size_[1] + at[1]) * size_[2] + at[2];
  std::fill_n(cubes_.begin() + first, z_end - z_begin, contents);
}

VoxelBox VoxelBox::coarser() const {
  CubeIndex low{}, size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = low_[axis] / 2;
    size[axis] = (low_[axis] + size_[axis] - 1) / 2 - low[axis] + 1;
  }
  VoxelBox box{low, size};
  std::size_t i = 0;
  for (int x = low[0]; x < low[0] + size[0]; ++x)
    for (int y = low[1]; y < low[1] + size[1]; ++y)
      for (int z = low[2]; z < low[2] + size[2]; ++z) {
        const Cube first = at({2 * x, 2 * y, 2 * z});
        bool same = first != Cube::kMixed;
        for (int child = 1; child < 8 && same; ++child)
          same = first == at({2 * x + (child & 1), 2 * y + (child >> 1 & 1), 2 * z + (child >> 2)});
        box.cubes_[i++] = same ? first : Cube::kMixed;
      }
  return box;
}

std::unique_ptr<octomap::OcTree> octree_of(VoxelBox voxels, double resolution) {
  std::vector<VoxelBox> levels;
  levels.push_back(std::move(voxels));
  while (levels.size() <= kTreeDepth) levels.push_back(levels.back().coarser());
  return octree_of_cubes(resolution, [&](int level, const CubeIndex& index) {
    return levels[static_cast<std::size_t>(level)].at(index);
  });
}

}  // namespace tandem
