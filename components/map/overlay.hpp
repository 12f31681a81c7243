// SPDX-License-Identifier: Apache-2.0
// Combines a static map and what is currently seen into one grid around the robot.
#pragma once

#include "tandem/map/grid.hpp"

namespace tandem {

/// Merges `in` into `out`: each cell of `out` takes the strongest state among itself and the cells
/// of `in` that it overlaps; occupied wins over free, and free over unknown.
void lay_over(Grid& out, const Grid& in);

/// The square within `reach` [m] of a point, at the resolution of `live`. A cell is occupied if it
/// overlaps an occupied cell of either grid, else free if it overlaps a free one, else unknown. The
/// cells are aligned with OctoMap's, and the square moves in whole metres, so that it does not
/// change with every step of the robot. Throws std::runtime_error if it would have more than
/// kMaxCells.
[[nodiscard]] Grid overlay(const Grid& base, const Grid& live, const Eigen::Vector2d& p_MC,
                           double reach);

/// Marks the known ground of a static map. Some maps contain obstacles only: if no cell of the grid
/// is free, all its unknown cells become free.
[[nodiscard]] Grid with_known_ground(Grid base);

/// The unknown cells of a grid; all others become free.
[[nodiscard]] Grid unknown_cells(Grid grid);

}  // namespace tandem
