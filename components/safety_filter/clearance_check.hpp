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

/// A pose that the robot may have had at the start, given the errors of the measured one, and what
/// is required of a cell nearer than the level if it did: that the cell comes no nearer than it was
/// at the start, or lies behind a near cell i,
///
///   g · u_i ≥ gap_i.                                                                        (2)
///
/// Unlike in (1), the deviation d is not added: among the possible poses there often is one that
/// nearly touches the cell, and then no motion could pass.
struct PossiblePose {
  Pose2 X_MB;                  ///< at the start
  Pose2 X_NM;                  ///< maps measured poses of the motion to those that start at X_MB
  std::vector<NearCell> near;  ///< the cells that are near by measurement, from this pose
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
///
/// The vectors of (1) are those of the measured pose. Beside a corner of the outline an error of
/// the pose turns them by up to a quarter turn, and a wrong heading makes one end of a long side
/// look nearer than the other. The same motion must therefore also be clear from the other poses
/// that the measurement allows, see PossiblePose.
struct RequiredClearance {
  double level = 0.0;               ///< [m]
  std::vector<NearCell> near = {};  ///< empty if the motion starts outside the level
  Footprint inset = {};  ///< smaller outline, clear of the cells that the outline overlaps
  std::vector<NearCell> overlapped = {};    ///< the overlapped cells, measured from `inset`
  std::vector<PossiblePose> possible = {};  ///< also empty if all of them overlap a cell
  DriftBounds drift = {};                   ///< bounds of the odometry's drift
};

/// The robot's outline with the radius of the disc around B that contains it.
struct BoundedFootprint {
  Footprint footprint;  ///< outline in B
  double radius = 0.0;  ///< circumradius [m]
};

/// The clearance required of a motion that starts at the measured pose X_MB, which is off by at
/// most `position_error` [m] and the drift's heading error.
[[nodiscard]] RequiredClearance required_clearance(double level, const Pose2& X_MB,
                                                   double position_error,
                                                   const BoundedFootprint& body,
                                                   const StaticMap& map, const DriftBounds& drift);

/// Whether the body keeps the required clearance on its whole path from X_MB, for all motions of
/// the cell. Uses conservative advancement: between two checks no point of the outline travels
/// farther than the clearance in hand, or than kCheckSpacing if that is larger.
[[nodiscard]] bool stays_clear(std::span<const TwistRange> envelope, const ShareCell& cell,
                               const Pose2& X_MB, const BoundedFootprint& body,
                               const StaticMap& map, const RequiredClearance& required);

}  // namespace tandem
