// SPDX-License-Identifier: Apache-2.0
// Whether all motions of an envelope are clear, by checking as few of them as it takes.
#pragma once

#include <functional>

#include "tandem/safety_filter/stopping_motion.hpp"

namespace tandem {

/// How far the ends of two neighbouring motions that are checked may be apart.
inline constexpr double kPathGap = 0.3;  ///< along their way [m]
inline constexpr double kTurnGap = 0.1;  ///< across it [m]

/// Whether the motions that keep their shares of both ranges, all of them, are clear. `lever` [m]
/// is the distance over which a turn moves the outline sideways.
///
/// The square of shares is cut into cells. A cell is clear if all its motions are, by the bound on
/// how far they differ from the one at its centre; else it is halved. Where the motions at its
/// corners come apart by no more than kPathGap and kTurnGap, those four decide. False also if that
/// takes cells too small, or more than 400 checks: then the robot is too fast for its bounds.
[[nodiscard]] bool all_motions_clear(const Reach& reach, double lever,
                                     const std::function<bool(const ShareCell&)>& is_clear);

}  // namespace tandem
