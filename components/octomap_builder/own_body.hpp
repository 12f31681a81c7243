// SPDX-License-Identifier: Apache-2.0
// Removes the returns of the robot's own body from a measurement.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "tandem/map/range_returns.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Returns inside the robot's outline, at any height, come from the robot itself: posts, a
/// footplate, a joystick's arm, a person's legs. They are dropped, so that their beams neither mark
/// nor clear anything.
class OwnBody {
 public:
  /// `footprint`: the robot's outline in B.
  explicit OwnBody(Footprint footprint);

  /// Drops them from the returns of a sensor at X_BS; returns how many.
  std::size_t drop(RangeReturns& echoes, const Eigen::Isometry3d& X_BS) const;

 private:
  [[nodiscard]] bool contains(const Eigen::Vector2d& p_BQ) const;

  Footprint footprint_;
  double radius_;  // [m] circumradius about base_link
};

}  // namespace tandem
