// SPDX-License-Identifier: Apache-2.0
// In: occupied cells. Out: few shapes that cover them and little else.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/free_space.hpp"
#include "tandem/obstacle_extractor/cover/passages.hpp"

namespace tandem {

/// Shape and the box around the cells that it answers for [m].
struct CoverShape {
  Obstacle obstacle;
  Eigen::Vector2d low, high;
};

/// From a point to the box around the shape's cells [m].
[[nodiscard]] inline double distance_to_cells(const CoverShape& shape, const Eigen::Vector2d& p) {
  return (shape.low - p).cwiseMax(p - shape.high).cwiseMax(0.0).norm();
}

struct CoverParams {
  Excess excess;           ///< no shape reaches deeper into free space
  double space_per_shape;  ///< free space that one shape less may take [m²]
  std::size_t crowded;     ///< where it takes more shapes than these, they get coarser
};

/// Shapes that cover the connected `clusters` at little cost,
///
///   J = Σ over shapes of c + A / A₁                                                    (1)
///
/// with A what the shape takes of the free space (FreeSpace::taken_by), A₁ = `space_per_shape`, and
/// c = 1, or 0.7 for a circle: it has three numbers where an ellipse has five, its distance costs
/// the planner less, and a pole stays one shape where ellipses are asked to be tight.
/// Clusters are split until each part's shape takes next to nothing; then the two neighbours whose
/// common shape lowers J most are joined, as long as one does; then neighbours are cut anew, and
/// pieces of parts go to their neighbours, where that lowers J. If more than `crowded` are left,
/// A₁ grows by 15 %, the reach into narrow ways by 3 cm up to that into open space, and it is
/// joined and, with nearly as few as wanted, cut again; so up to sixteen times. Where that closes
/// one of `ways` it is done again with shapes that reach no deeper than `excess.kept` there; if
/// that does not help, the shapes are those before they got coarser. Every cell lies wholly in a
/// shape; a single cell has one whatever its excess. Ids are 1 + the index of the lowest cell that
/// the shape answers for. No randomness: equal arguments give equal shapes.
[[nodiscard]] std::vector<CoverShape> cover(const Grid& grid,
                                            const std::vector<std::vector<CellIndex>>& clusters,
                                            const FreeSpace& space, const Passages& ways,
                                            const CoverParams& params);

}  // namespace tandem
