// SPDX-License-Identifier: Apache-2.0
// Projects a band of heights of an OctoMap onto the plane of cells that a body in that band can
// hit.
#pragma once

#include <octomap/OcTree.h>

#include <string_view>

#include "tandem/config/params.hpp"
#include "tandem/map/grid.hpp"

namespace tandem {

/// The band of heights that the robot's body sweeps, relative to the floor.
struct SliceParams {
  double z_min = 0.10;
  double z_max = 1.0;
  double floor = 0.0;
  double drop_off = 0.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("z_min", z_min, Range{-10.0, 100.0},
          "[m] lower bound of the slice above the floor: the robot's ground clearance");
    field("z_max", z_max, Range{-10.0, 100.0},
          "[m] upper bound of the slice above the floor: the robot's height");
    field("floor", floor, Range{-1000.0, 1000.0}, "[m] height of the floor in the map's frame");
    field("drop_off", drop_off, Range{0.0, 10.0},
          "[m] where the floor is observed free down to this depth (stairs, kerbs), the cell is an "
          "obstacle; 0: drop-offs are not detected");
  }
};

/// Cells at the tree's resolution over its bounding box. A cell is occupied if any occupied voxel
/// of its column, including pruned ones, reaches into the open band (z_min, z_max); else free if
/// any voxel there is known to be free; else unknown. With `drop_off` > 0 a cell is also occupied
/// if its floor is missing: nothing occupied reaches into (−drop_off, z_min), and the voxel
/// `drop_off` below the floor is known to be free. Unseen ground is not a drop-off. Throws
/// std::invalid_argument if z_min ≥ z_max, or with a drop_off if z_min ≤ −drop_off;
/// std::runtime_error if the plane would have more than 10⁸ cells.
[[nodiscard]] Grid slice(const octomap::OcTree& tree, const SliceParams& params);

/// The same for the data of a binary map (see count_binary_nodes, which must accept them) at this
/// resolution [m], without building its tree.
[[nodiscard]] Grid slice_binary(std::string_view data, double resolution,
                                const SliceParams& params);

}  // namespace tandem
