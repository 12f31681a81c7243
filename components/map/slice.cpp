// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/slice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "tandem/map/detail/octree_keys.hpp"
#include "tandem/map/detail/touching.hpp"

namespace tandem {
namespace {

// Voxels [begin, end) along x and y, as OctoMap keys.
struct KeyBox {
  std::array<int, 2> begin{kLastKey + 1, kLastKey + 1}, end{0, 0};
};

int voxels(unsigned depth) { return 1 << (kTreeDepth - static_cast<int>(depth)); }

KeyBox bounds(const octomap::OcTree& tree) {
  KeyBox box;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const octomap::OcTreeKey key = leaf.getIndexKey();
    for (unsigned axis = 0; axis < 2; ++axis) {
      box.begin[axis] = std::min(box.begin[axis], static_cast<int>(key[axis]));
      box.end[axis] = std::max(box.end[axis], key[axis] + voxels(leaf.getDepth()));
    }
  }
  return box;
}

Grid unknown_grid(double resolution, const KeyBox& box) {
  Grid grid;
  grid.resolution = resolution;
  grid.width = std::max(0, box.end[0] - box.begin[0]);
  grid.height = std::max(0, box.end[1] - box.begin[1]);
  const auto count = static_cast<std::int64_t>(grid.width) * grid.height;
  if (count > kMaxCells)
    throw std::runtime_error("the map has " + std::to_string(grid.width) + " × " +
                             std::to_string(grid.height) +
                             " cells, more than 10⁸: crop it or make it coarser");
  if (count > 0)
    grid.origin = {resolution * (box.begin[0] - kMiddleKey),
                   resolution * (box.begin[1] - kMiddleKey)};
  grid.cells.assign(static_cast<std::size_t>(count), Cell::kUnknown);
  return grid;
}

// Sets every cell under a voxel to its state; occupied wins.
void stamp(Grid& grid, std::array<int, 2> first, int size, Cell state) {
  for (int iy = first[1]; iy < first[1] + size; ++iy)
    for (int ix = first[0]; ix < first[0] + size; ++ix) {
      Cell& cell = grid.cells[static_cast<std::size_t>(iy) * static_cast<std::size_t>(grid.width) +
                              static_cast<std::size_t>(ix)];
      if (cell != Cell::kOccupied) cell = state;
    }
}

// Visits every leaf that reaches into the heights (low, high) [m], with the key of its lowest voxel
// and whether it reaches down to `low`.
template <class Visit>
void for_leaves_between(const octomap::OcTree& tree, double low, double high, const Visit& visit) {
  const double from_voxel = low / tree.getResolution() + kMiddleKey + kTouching;
  const double to_voxel = high / tree.getResolution() + kMiddleKey - kTouching;
  if (to_voxel < 0.0 || from_voxel > kLastKey + 1) return;
  const auto key = [](double value) {
    return static_cast<octomap::key_type>(std::clamp(std::floor(value), 0.0, 1.0 * kLastKey));
  };
  const octomap::OcTreeKey from(0, 0, key(from_voxel)), to(kLastKey, kLastKey, key(to_voxel));
  for (auto leaf = tree.begin_leafs_bbx(from, to); leaf != tree.end_leafs_bbx(); ++leaf) {
    const octomap::OcTreeKey first = leaf.getIndexKey();
    // The iterator also yields large leaves that end just below the band.
    if (first[2] + voxels(leaf.getDepth()) > from[2]) visit(leaf, first, first[2] <= from[2]);
  }
}

// Marks cells that are known free at the depth of a drop-off, with no floor above.
void stamp_drop_offs(const octomap::OcTree& tree, const SliceParams& params, const KeyBox& box,
                     Grid& grid) {
  Grid below = unknown_grid(grid.resolution, box);
  for_leaves_between(tree, params.floor - params.drop_off, params.floor + params.z_min,
                     [&](const auto& leaf, const octomap::OcTreeKey& first, bool is_lowest) {
                       const bool is_floor = tree.isNodeOccupied(*leaf);
                       if (is_floor || is_lowest)
                         stamp(below, {first[0] - box.begin[0], first[1] - box.begin[1]},
                               voxels(leaf.getDepth()), is_floor ? Cell::kOccupied : Cell::kFree);
                     });
  for (std::size_t i = 0; i < grid.cells.size(); ++i)
    if (below.cells[i] == Cell::kFree) grid.cells[i] = Cell::kOccupied;
}

}  // namespace

Grid slice(const octomap::OcTree& tree, const SliceParams& params) {
  check(params);
  if (!(params.z_min < params.z_max))
    throw std::invalid_argument("slice: z_min must be below z_max");
  if (params.drop_off > 0.0 && !(params.z_min > -params.drop_off))
    throw std::invalid_argument("slice: z_min must be above -drop_off");
  const KeyBox box = bounds(tree);
  Grid grid = unknown_grid(tree.getResolution(), box);

  if (grid.cells.empty()) return grid;
  for_leaves_between(tree, params.floor + params.z_min, params.floor + params.z_max,
                     [&](const auto& leaf, const octomap::OcTreeKey& first, bool) {
                       stamp(grid, {first[0] - box.begin[0], first[1] - box.begin[1]},
                             voxels(leaf.getDepth()),
                             tree.isNodeOccupied(*leaf) ? Cell::kOccupied : Cell::kFree);
                     });
  if (params.drop_off > 0.0) stamp_drop_offs(tree, params, box, grid);
  return grid;
}

}  // namespace tandem
