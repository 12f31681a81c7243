// SPDX-License-Identifier: Apache-2.0
// In: echoes of a sensor on the robot. Out: those that are not of the robot itself.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "tandem/map/range_returns.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// RangeReturns inside the robot's outline, at any height, are of the robot itself: posts, a
/// footplate, a joystick's arm, a person's legs. Drops them, so that their beams neither mark nor
/// clear anything.
class OwnBody {
 public:
  explicit OwnBody(Footprint footprint);

  /// How many echoes of a sensor at X_BS were dropped.
  std::size_t drop(RangeReturns& echoes, const Eigen::Isometry3d& X_BS) const;

 private:
  [[nodiscard]] bool contains(const Eigen::Vector2d& p_BQ) const;

  Footprint footprint_;
  double radius_;  // [m] about base_link, of all its points
};

}  // namespace tandem
