// SPDX-License-Identifier: Apache-2.0
// In: a pose that the person wants, guidance lines. Out: the pose drawn towards the nearest line.
#pragma once

#include <span>

#include "tandem/model/guidance_line.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// The pose moved towards the nearest point of the lines, and turned along the line there:
///
///   p' = p + s (p_line − p),   θ' = θ + s wrap(θ_line − θ),   s = strength (1 − (d / reach)²)²
///
/// with d the distance to the line and θ_line its direction, in the sense that is nearer to θ. A
/// soft guidance fixture: unchanged on the line and from `reach` on, continuous in between, and
/// what crosses the line (more than 60° off it) is not turned, only moved less: s falls to zero as
/// cos²(1.5 wrap(θ_line − θ)) does. After Bettini et al. 2004, who weaken motion off the preferred
/// direction.
[[nodiscard]] Pose2 guided(const Pose2& X_M, std::span<const GuidanceLine> lines);

}  // namespace tandem
