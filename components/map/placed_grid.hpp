// SPDX-License-Identifier: Apache-2.0
// Transforms a grid into the map frame without losing an obstacle.
#pragma once

#include "tandem/map/grid.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// The grid whose frame F lies at X_MF, as a grid of M with the same resolution. A cell is occupied
/// if an occupied cell of F, grown by `spread` [m] to each side, overlaps it; else unknown if an
/// unknown one or space beyond the grid does; else free. The result therefore holds for every pose
/// that moves no point of the grid by more than `spread`.
///
/// Without rotation and spread the grid is shifted, and nothing is lost or added. Throws
/// std::runtime_error if the result would have more than kMaxCells.
[[nodiscard]] Grid placed(Grid grid, const Pose2& X_MF, double spread = 0.0);

}  // namespace tandem
