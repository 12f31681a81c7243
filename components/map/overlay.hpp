// SPDX-License-Identifier: Apache-2.0
// In: a map that stays and what is seen now. Out: both as one grid round the robot.
#pragma once

#include "tandem/map/grid.hpp"

namespace tandem {

/// Gives each cell of `out` what the cells of `in` that it overlaps say, and keeps what it says:
/// occupied before free before unknown.
void lay_over(Grid& out, const Grid& in);

/// The square within `reach` [m] of a point, at the resolution of `live`. A cell is occupied if it
/// overlaps an occupied cell of either grid, else free if it overlaps a free one, else unknown. The
/// cells lie where those of OctoMap lie, and the square moves by whole metres, so that it does not
/// change at each step of the robot. Throws std::runtime_error if it had more than kMostCells.
[[nodiscard]] Grid overlay(const Grid& base, const Grid& live, const Eigen::Vector2d& p_MC,
                           double reach);

/// Of a map that stays: where it knows the ground. Some maps hold obstacles alone; in the box of
/// such a one, all that is not an obstacle counts as free.
[[nodiscard]] Grid with_known_ground(Grid base);

/// The cells of a grid that are unknown, and nothing else: all others are free.
[[nodiscard]] Grid unknown_cells(Grid grid);

}  // namespace tandem
