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
#include "tandem/map/octomap_bytes.hpp"

namespace tandem {
namespace {

// Voxels [begin, end) along x and y, as OctoMap keys.
struct KeyBox {
  std::array<int, 2> begin{kLastKey + 1, kLastKey + 1}, end{0, 0};
};

int voxels(unsigned depth) { return 1 << (kTreeDepth - static_cast<int>(depth)); }

// The leaves of an octree. `each` visits all of them, `between` those that reach into a span of
// keys along z: with the key of the lowest voxel, the side in voxels, and whether it is occupied.
class TreeLeaves {
 public:
  explicit TreeLeaves(const octomap::OcTree& tree) : tree_{tree} {}

  template <class Visit>
  void each(const Visit& visit) const {
    for (auto leaf = tree_.begin_leafs(); leaf != tree_.end_leafs(); ++leaf)
      visit(leaf.getIndexKey(), voxels(leaf.getDepth()), tree_.isNodeOccupied(*leaf));
  }
  template <class Visit>
  void between(octomap::key_type low, octomap::key_type high, const Visit& visit) const {
    const octomap::OcTreeKey from(0, 0, low), to(kLastKey, kLastKey, high);
    for (auto leaf = tree_.begin_leafs_bbx(from, to); leaf != tree_.end_leafs_bbx(); ++leaf) {
      const octomap::OcTreeKey first = leaf.getIndexKey();
      const int side = voxels(leaf.getDepth());
      // The iterator also yields large leaves that end just below the span.
      if (first[2] + side > low) visit(first, side, tree_.isNodeOccupied(*leaf));
    }
  }

 private:
  const octomap::OcTree& tree_;
};

class BinaryLeaves {
 public:
  explicit BinaryLeaves(std::string_view data) : data_{data} {}

  template <class Visit>
  void each(const Visit& visit) const {
    for_binary_leaves(data_, visit);
  }
  template <class Visit>
  void between(octomap::key_type low, octomap::key_type high, const Visit& visit) const {
    for_binary_leaves(data_, [&](const octomap::OcTreeKey& first, int side, bool is_occupied) {
      if (first[2] + side > low && first[2] <= high) visit(first, side, is_occupied);
    });
  }

 private:
  std::string_view data_;
};

template <class Leaves>
KeyBox bounds(const Leaves& leaves) {
  KeyBox box;
  leaves.each([&](const octomap::OcTreeKey& first, int side, bool) {
    for (unsigned axis = 0; axis < 2; ++axis) {
      box.begin[axis] = std::min(box.begin[axis], static_cast<int>(first[axis]));
      box.end[axis] = std::max(box.end[axis], first[axis] + side);
    }
  });
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

// Visits every leaf that reaches into the heights (low, high) [m], with the key of its lowest
// voxel, its side, whether it is occupied, and whether it reaches down to `low`.
template <class Leaves, class Visit>
void for_leaves_between(const Leaves& leaves, double resolution, double low, double high,
                        const Visit& visit) {
  const double from_voxel = low / resolution + kMiddleKey + kTouching;
  const double to_voxel = high / resolution + kMiddleKey - kTouching;
  if (to_voxel < 0.0 || from_voxel > kLastKey + 1) return;
  const auto key = [](double value) {
    return static_cast<octomap::key_type>(std::clamp(std::floor(value), 0.0, 1.0 * kLastKey));
  };
  const octomap::key_type from = key(from_voxel);
  leaves.between(from, key(to_voxel),
                 [&](const octomap::OcTreeKey& first, int side, bool is_occupied) {
                   visit(first, side, is_occupied, first[2] <= from);
                 });
}

// Marks cells that are known free at the depth of a drop-off, with no floor above.
template <class Leaves>
void stamp_drop_offs(const Leaves& leaves, const SliceParams& params, const KeyBox& box,
                     Grid& grid) {
  Grid below = unknown_grid(grid.resolution, box);
  for_leaves_between(leaves, grid.resolution, params.floor - params.drop_off,
                     params.floor + params.z_min,
                     [&](const octomap::OcTreeKey& first, int side, bool is_floor, bool is_lowest) {
                       if (is_floor || is_lowest)
                         stamp(below, {first[0] - box.begin[0], first[1] - box.begin[1]}, side,
                               is_floor ? Cell::kOccupied : Cell::kFree);
                     });
  for (std::size_t i = 0; i < grid.cells.size(); ++i)
    if (below.cells[i] == Cell::kFree) grid.cells[i] = Cell::kOccupied;
}

template <class Leaves>
Grid slice_leaves(const Leaves& leaves, double resolution, const SliceParams& params) {
  check(params);
  if (!(params.z_min < params.z_max))
    throw std::invalid_argument("slice: z_min must be below z_max");
  if (params.drop_off > 0.0 && !(params.z_min > -params.drop_off))
    throw std::invalid_argument("slice: z_min must be above -drop_off");
  const KeyBox box = bounds(leaves);
  Grid grid = unknown_grid(resolution, box);
  if (grid.cells.empty()) return grid;
  for_leaves_between(leaves, resolution, params.floor + params.z_min, params.floor + params.z_max,
                     [&](const octomap::OcTreeKey& first, int side, bool is_occupied, bool) {
                       stamp(grid, {first[0] - box.begin[0], first[1] - box.begin[1]}, side,
                             is_occupied ? Cell::kOccupied : Cell::kFree);
                     });
  if (params.drop_off > 0.0) stamp_drop_offs(leaves, params, box, grid);
  return grid;
}

}  // namespace

Grid slice(const octomap::OcTree& tree, const SliceParams& params) {
  return slice_leaves(TreeLeaves{tree}, tree.getResolution(), params);
}

Grid slice_binary(std::string_view data, double resolution, const SliceParams& params) {
  return slice_leaves(BinaryLeaves{data}, resolution, params);
}

}  // namespace tandem
