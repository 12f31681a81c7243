// SPDX-License-Identifier: Apache-2.0
// Checks that a motion keeps its distance from the map's obstacles all the way.
#pragma once

#include <span>
#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/safety_filter/deviation.hpp"
#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

/// Travel of the outline's fastest point between two checked poses where it gets narrow [m]. In
/// between, clearance is at most half of it below the smaller of the two.
inline constexpr double kCheckSpacing = 0.008;

/// A cell that is nearer to the outline than the margin where the motion starts.
struct NearCell {
  Eigen::Vector2d u_M;  ///< unit vector from the outline to the cell, in M
  double gap = 0.0;     ///< [m]
};

/// Clearance that is required of a motion.
///
/// At every pose each cell must be at least level + d away, where d is the deviation so far,
/// deviation.hpp (3). A robot that starts inside of the level could then never leave: there, a cell
/// may be nearer if it lies behind one of the cells that were near at the start, that is, if for
/// some near cell i, and with g the vector from the outline's to the cell's nearest point,
///
///   g · u_i ≥ gap_i + d.                                                                    (1)
///
/// So the robot may slide along a wall that it is too close to, but comes no closer to it, and to
/// nothing on its other sides. Of cells that the outline overlaps at the start, (1) asks the same
/// with a smaller outline, which is clear of them.
struct RequiredClearance {
  double level = 0.0;                ///< [m]
  std::vector<NearCell> near;        ///< empty if the motion starts outside of the level
  Footprint inset;                   ///< clear of the cells that the outline overlaps …
  std::vector<NearCell> overlapped;  ///< … which are these, seen from it
  DriftBounds drift;
};

/// The robot's body, as far as the check needs it.
struct Body {
  Footprint footprint;
  double radius = 0.0;  ///< circumradius [m]
};

/// The clearance that is required of a motion from X_MB.
[[nodiscard]] RequiredClearance required_clearance(double level, const Pose2& X_MB,
                                                   const Body& body, const StaticMap& map,
                                                   const DriftBounds& drift);

/// Whether the body keeps the required clearance on its whole way from X_MB, in all motions of the
/// cell. Conservative advancement: no point of the outline travels further between two checks than
/// the clearance in hand, or kCheckSpacing where there is less.
[[nodiscard]] bool stays_clear(std::span<const TwistRange> envelope, const ShareCell& cell,
                               const Pose2& X_MB, const Body& body, const StaticMap& map,
                               const RequiredClearance& required);

}  // namespace tandem
