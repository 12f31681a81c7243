// SPDX-License-Identifier: Apache-2.0
// In: a motion, where it starts, the map. Out: whether it keeps its distance all the way.
#pragma once

#include "map/static_map.hpp"
#include "safety_filter/stopping_motion.hpp"

namespace tandem {

/// Travel of the outline's fastest point between two checked poses where it gets narrow [m]. In
/// between, clearance is at most half of it below the smaller of the two.
inline constexpr double kCheckSpacing = 0.008;

/// Clearance that is required of a motion: it grows with the way, as errors of motion do,
///
///   r = level + ∫ per_rim (|v_left| + |v_right|) + per_path |v| dt                        (1)
struct RequiredClearance {
  double level = 0.0;     ///< [m]
  double per_rim = 0.0;   ///< [m per m that both wheels' rims travel]
  double per_path = 0.0;  ///< [m per m of path]
};

/// The robot's body, as far as the check needs it.
struct Body {
  Footprint footprint;
  double radius = 0.0;            ///< circumradius [m]
  double wheel_separation = 0.0;  ///< [m]
};

/// Whether the body keeps the required clearance on its whole way from X_MB. Conservative
/// advancement: no point of the outline travels further between two checks than the clearance in
/// hand, or kCheckSpacing where there is less.
[[nodiscard]] bool stays_clear(const Motion& motion, const Pose2& X_MB, const Body& body,
                               const StaticMap& map, const RequiredClearance& required);

}  // namespace tandem
