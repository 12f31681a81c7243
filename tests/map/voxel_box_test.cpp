// SPDX-License-Identifier: Apache-2.0
// Compares trees built from a box of voxels with those that OctoMap builds voxel by voxel.
#include "tandem/map/detail/voxel_box.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tandem/map/detail/octree_keys.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem {
namespace {

struct Trees {
  std::unique_ptr<octomap::OcTree> ours, octomaps;
};

void set(octomap::OcTree& tree, const CubeIndex& index, Cube contents) {
  const float log_odds =
      contents == Cube::kOccupied ? tree.getClampingThresMaxLog() : tree.getClampingThresMinLog();
  tree.setNodeValue(octomap::OcTreeKey(static_cast<octomap::key_type>(index[0]),
                                       static_cast<octomap::key_type>(index[1]),
                                       static_cast<octomap::key_type>(index[2])),
                    log_odds, true);
}

// A box at a random place that holds random columns, some of them in blocks that can be pruned.
Trees random_trees(unsigned seed) {
  std::mt19937 random{seed};
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  CubeIndex low{}, size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = kMiddleKey - 20 + below(40);
    size[axis] = 1 + below(40);
  }
  VoxelBox box{low, size};
  Trees trees{nullptr, std::make_unique<octomap::OcTree>(0.1)};
  for (int n = 1 + below(8); n > 0; --n) {
    const int width = 1 + below(16), x0 = low[0] + below(size[0]), y0 = low[1] + below(size[1]);
    const int z0 = low[2] + below(size[2]), z1 = z0 + 1 + below(low[2] + size[2] - z0);
    const Cube contents = below(2) == 0 ? Cube::kFree : Cube::kOccupied;
    for (int x = x0; x < std::min(x0 + width, low[0] + size[0]); ++x)
      for (int y = y0; y < std::min(y0 + width, low[1] + size[1]); ++y) {
        box.set_column(x, y, z0, z1, contents);
        for (int z = z0; z < z1; ++z) set(*trees.octomaps, {x, y, z}, contents);
      }
  }
  trees.octomaps->updateInnerOccupancy();
  trees.octomaps->prune();
  trees.ours = octree_of(std::move(box), 0.1);
  return trees;
}

TEST(VoxelBox, GivesTheTreeThatOctoMapBuildsVoxelByVoxel) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    const auto [ours, octomaps] = random_trees(seed);
    ASSERT_EQ(bt_file_bytes(*ours), bt_file_bytes(*octomaps));
    ASSERT_TRUE(*ours == *octomaps);  // the values too
  }
}

TEST(VoxelBox, GivesAnEmptyTreeIfNothingIsKnown) {
  const auto tree = octree_of(VoxelBox{{32768, 32768, 32768}, {3, 4, 5}}, 0.1);
  EXPECT_EQ(tree->size(), 0U);
  EXPECT_EQ(tree->getRoot(), nullptr);
}

TEST(VoxelBox, WhatIsOutsideIsUnknown) {
  VoxelBox box{{10, 20, 30}, {2, 2, 2}};
  box.set_column(10, 20, 30, 32, Cube::kFree);
  EXPECT_EQ(box.at({10, 20, 31}), Cube::kFree);
  EXPECT_EQ(box.at({11, 20, 31}), Cube::kUnknown);
  EXPECT_EQ(box.at({10, 20, 32}), Cube::kUnknown);
  EXPECT_EQ(box.at({9, 20, 31}), Cube::kUnknown);
  EXPECT_EQ(box.coarser().at({5, 10, 15}), Cube::kMixed);
}

}  // namespace
}  // namespace tandem
