// SPDX-License-Identifier: Apache-2.0
// In: a grid whose frame is not the map's. Out: the same in the map, with no obstacle lost.
#pragma once

#include "tandem/map/grid.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// The grid whose frame F lies at X_MF, as a grid of M with the same resolution. A cell is occupied
/// if an occupied cell of F, grown by `spread` [m] to each side, reaches into it; else unknown if
/// an unknown one does, or what lies beyond the grid; else free. So the result holds for each pose
/// that moves no point of it by more than `spread`.
///
/// Without a turn and a spread the grid is shifted and nothing is lost or added. Throws
/// std::runtime_error if the result would have more than kMostCells.
[[nodiscard]] Grid placed(Grid grid, const Pose2& X_MF, double spread = 0.0);

}  // namespace tandem
