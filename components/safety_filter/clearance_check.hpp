// SPDX-License-Identifier: Apache-2.0
// Checks that a motion keeps the required clearance from the map's obstacles along its whole path.
#pragma once

#include <span>
#include <vector>

#include "tandem/map/static_map.hpp"
#include "tandem/safety_filter/deviation.hpp"
#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

/// Travel of the outline's fastest point between two checked poses when the clearance is small [m].
/// Between two checks the clearance drops below the smaller of the two by at most half of this.
inline constexpr double kCheckSpacing = 0.008;

/// An obstacle cell closer to the outline than the required level at the start of the motion.
struct NearCell {
  Eigen::Vector2d u_M;  ///< unit vector from the outline to the cell, in M
  double gap = 0.0;     ///< [m]
};

/// Clearance that is required of a motion.
///
/// At every pose each obstacle cell must be at least level + d away, where d is the deviation
/// accumulated so far, deviation.hpp (3). A robot that starts closer than the level could then
/// never leave. In that case a cell may be closer if it lies behind one of the cells that were near
/// at the start: for some near cell i, with g the vector from the outline's nearest point to the
/// cell's nearest point,
///
///   g · u_i ≥ gap_i + d.                                                                    (1)
///
/// The robot may therefore slide along a wall it is too close to, but may approach neither that
/// wall nor anything on its other sides. For cells that the outline overlaps at the start, (1) is
/// evaluated with a smaller outline that is clear of them.
struct RequiredClearance {
  double level = 0.0;          ///< [m]
  std::vector<NearCell> near;  ///< empty if the motion starts outside the level
  Footprint inset;             ///< smaller outline, clear of the cells that the outline overlaps
  std::vector<NearCell> overlapped;  ///< the overlapped cells, measured from `inset`
  DriftBounds drift;                 ///< bounds of the odometry's drift
};

/// The robot's outline and its size.
struct Body {
  Footprint footprint;  ///< outline in B
  double radius = 0.0;  ///< circumradius [m]
};

/// The clearance required of a motion that starts at X_MB.
[[nodiscard]] RequiredClearance required_clearance(double level, const Pose2& X_MB,
                                                   const Body& body, const StaticMap& map,
                                                   const DriftBounds& drift);

/// Whether the body keeps the required clearance on its whole path from X_MB, for all motions of
/// the cell. Uses conservative advancement: between two checks no point of the outline travels
/// farther than the clearance in hand, or than kCheckSpacing if that is larger.
[[nodiscard]] bool stays_clear(std::span<const TwistRange> envelope, const ShareCell& cell,
                               const Pose2& X_MB, const Body& body, const StaticMap& map,
                               const RequiredClearance& required);

}  // namespace tandem
