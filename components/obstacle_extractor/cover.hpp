// SPDX-License-Identifier: Apache-2.0
// In: occupied cells. Out: few shapes that cover them and little else.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "map/grid.hpp"
#include "model/obstacle.hpp"
#include "obstacle_extractor/free_depth.hpp"

namespace tandem {

/// Index of a cell in its grid.
struct CellIndex {
  int ix = 0, iy = 0;

  bool operator==(const CellIndex&) const = default;
};

/// Shape and the box around the cells that it answers for [m].
struct CoverShape {
  Obstacle obstacle;
  Eigen::Vector2d low, high;
};

/// Each of the connected `clusters` is split until the best ellipse around each part reaches at
/// most `max_excess` into free space; neighbouring parts are joined again where one ellipse does
/// for both; shapes whose cells others cover as well are dropped. Every cell lies wholly in a
/// shape; a single cell has one whatever its excess. Ids are 1 + the index of the lowest cell
/// that the shape answers for.
[[nodiscard]] std::vector<CoverShape> cover(const Grid& grid,
                                            const std::vector<std::vector<CellIndex>>& clusters,
                                            const FreeDepth& depth, double max_excess);

}  // namespace tandem
