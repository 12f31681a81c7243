// SPDX-License-Identifier: Apache-2.0
// Generates a cluttered world like those of BARN, passable for a robot, from a seed.
#pragma once

#include <Eigen/Core>

#include "tandem/config/params.hpp"
#include "tandem/map/map_description.hpp"

namespace tandem {

struct ClutterParams {
  double fill = 0.25;
  int smoothing = 3;
  double width = 0.60;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("fill", fill, Range{0.0, 0.6}, "fraction of cells filled at random");
    field("smoothing", smoothing, Range{0, 20}, "steps of the cellular automaton");
    field("width", width, Range{0.1, 1.5},
          "[m] diameter of the disc that must be able to pass from start to goal");
  }
};

/// Start of the robot, heading +y, and its goal [m], as in BARN.
inline const Eigen::Vector2d kClutterStart{-2.25, 3.0}, kClutterGoal{-2.25, 13.0};

/// A corridor 4.5 m wide with cylinders of ⌀ 0.15 m on a lattice of 0.15 m from y = 4.65 to 9.15.
/// It is generated like the worlds of BARN (Perille et al. 2020): cells are filled at random, then
/// smoothed by a cellular automaton (five or more filled neighbours fill a cell, two or fewer empty
/// it). Worlds whose goal cannot be reached are discarded, and the next world of the same seed is
/// tried. Equal seeds and parameters give equal worlds. Throws std::runtime_error if none of 200
/// tries can be passed.
[[nodiscard]] MapDescription clutter_world(unsigned seed, const ClutterParams& params);

}  // namespace tandem
