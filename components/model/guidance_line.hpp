// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace tandem {

/// A line that attracts the robot, such as a lane along a corridor. Points in M [m].
struct GuidanceLine {
  std::string name;                   ///< empty if the file gives none
  std::vector<Eigen::Vector2d> p_MV;  ///< vertices in M [m]
  double reach = 0.5;                 ///< [m] distance beyond which the line has no effect
  double strength = 0.5;  ///< [0, 1] fraction of the distance to the line that is corrected near it
};

}  // namespace tandem
