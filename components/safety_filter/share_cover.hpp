// SPDX-License-Identifier: Apache-2.0
// Decides whether all motions of an envelope are clear with as few checks as possible.
#pragma once

#include <functional>

#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

/// Largest distance between the ends of two neighbouring checked motions.
inline constexpr double kPathGap = 0.3;  ///< along their path [m]
inline constexpr double kTurnGap = 0.1;  ///< across their path [m]

/// Whether all motions with constant shares of both ranges are clear. `lever` [m] is the distance
/// over which a turn moves the outline sideways.
///
/// The unit square of shares is subdivided into cells. A cell is clear if the check of its centre,
/// widened by the bound on how far its other motions differ, succeeds; otherwise it is halved.
/// Where the motions at a cell's corners are no farther apart than kPathGap and kTurnGap, those
/// four decide. Also returns false if the cells would get too small or more than 400 checks are
/// needed: the robot is then too fast for its bounds.
[[nodiscard]] bool all_motions_clear(const Reach& reach, double lever,
                                     const std::function<bool(const ShareCell&)>& is_clear);

}  // namespace tandem
