// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace tandem {

/// A way that the robot is drawn to, as to a lane along a corridor. Points in M [m].
struct GuidanceLine {
  std::string name;
  std::vector<Eigen::Vector2d> p_MV;
  double reach = 0.5;     ///< [m] nothing is drawn from beyond it
  double strength = 0.5;  ///< [0, 1] of the way to the line that is gained, near it
};

}  // namespace tandem
