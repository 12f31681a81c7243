// SPDX-License-Identifier: Apache-2.0
// Soft virtual fixtures: draws a reference pose toward a guidance line.
#pragma once

#include <span>

#include "tandem/model/guidance_line.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Moves the pose toward the nearest point of a line and turns it along the line there:
///
///   p' = p + s (p_line − p),   θ' = θ + s wrap(θ_line − θ),   s = strength (1 − (d / reach)²)²
///
/// with d [m] the distance to the line and θ_line its direction, in whichever sense is closer to θ.
/// s is also multiplied by cos²(1.5 wrap(θ_line − θ)): a pose that crosses the line at 60° or more
/// is unchanged, and so is one at `reach` or beyond. Of several lines the one with the largest s
/// acts. After Bettini et al. 2004, who attenuate motion off the preferred direction.
[[nodiscard]] Pose2 guided(const Pose2& X_M, std::span<const GuidanceLine> lines);

}  // namespace tandem
