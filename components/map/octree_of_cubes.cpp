// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/detail/octree_of_cubes.hpp"

#include <sstream>
#include <string>

#include "tandem/map/detail/octree_keys.hpp"

namespace tandem {
namespace {

CubeIndex child_of(const CubeIndex& index, int i) {
  return {2 * index[0] + (i & 1), 2 * index[1] + (i >> 1 & 1), 2 * index[2] + (i >> 2)};
}

// Appends a node as in a .bt file: two bits per child, then the mixed children one by one.
void write(int level, const CubeIndex& index, const CubeContents& contents, std::string& out) {
  std::array<Cube, 8> children{};
  unsigned record = 0;
  for (int i = 0; i < 8; ++i) {
    auto& child = children[static_cast<std::size_t>(i)];
    child = contents(level - 1, child_of(index, i));
    record |= static_cast<unsigned>(child) << (2 * i);
  }
  out += static_cast<char>(record & 0xffU);
  out += static_cast<char>(record >> 8U);
  for (int i = 0; i < 8; ++i)
    if (children[static_cast<std::size_t>(i)] == Cube::kMixed)
      write(level - 1, child_of(index, i), contents, out);
}

}  // namespace

std::unique_ptr<octomap::OcTree> octree_of_cubes(double resolution, const CubeContents& contents) {
  std::string bytes;
  write(kTreeDepth, {0, 0, 0}, contents, bytes);
  auto tree = std::make_unique<octomap::OcTree>(resolution);
  if (bytes == std::string(2, '\0')) return tree;  // a root without children would be a leaf
  std::istringstream stream{std::move(bytes)};
  tree->readBinaryData(stream);
  tree->getRoot()->updateOccupancyChildren();  // OctoMap leaves the root occupied
  return tree;
}

}  // namespace tandem
