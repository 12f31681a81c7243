// SPDX-License-Identifier: Apache-2.0
// Covers occupied cells by few shapes that take little free space.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/free_space.hpp"
#include "tandem/obstacle_extractor/cover/passages.hpp"

namespace tandem {

/// A shape and the bounding box of the cells it covers [m].
struct CoverShape {
  Obstacle obstacle;          ///< the shape
  Eigen::Vector2d low, high;  ///< corners of the box in M [m]
};

/// Distance from a point to the bounding box of the shape's cells [m].
[[nodiscard]] inline double distance_to_cells(const CoverShape& shape, const Eigen::Vector2d& p) {
  return (shape.low - p).cwiseMax(p - shape.high).cwiseMax(0.0).norm();
}

/// How closely the shapes must fit.
struct CoverParams {
  Excess excess;           ///< maximum reach of a shape into free space
  double space_per_shape;  ///< free space that saving one shape may cost [m²]
  std::size_t crowded;     ///< with more shapes than this they are made coarser
};

/// Shapes that cover the connected `clusters` at little cost,
///
///   J = Σ over shapes of c + A / A₁                                                    (1)
///
/// where A is the free area lost to the shape (FreeSpace::taken_by) and A₁ = `space_per_shape`. c
/// is 0.7 for a circle and 1 for other shapes: a circle has three parameters instead of five, its
/// distance is cheaper for the planner, and poles stay single shapes even when the others have to
/// be tight.
///
/// Clusters are split until each part's shape takes almost no free space. Then the pair of
/// neighbours whose common shape lowers J most is joined until no pair does. Then neighbouring
/// parts are cut again and pieces are moved between neighbours as long as that lowers J. If more
/// than `crowded` shapes are left, A₁ grows by 15 % and the reach into narrow passages by 3 cm, up
/// to the reach into open space, and parts are joined again and, once the count is near `crowded`,
/// cut again; this is repeated up to sixteen times. If that closes a passage of `ways`, it is
/// repeated with shapes that reach no deeper than `excess.kept` there; if that does not help, the
/// shapes before coarsening are returned. Every cell lies wholly in one shape; a single cell always
/// gets a shape, whatever its excess. Ids are 1 + the index of the lowest cell that the shape
/// covers. Deterministic: equal arguments give equal shapes.
[[nodiscard]] std::vector<CoverShape> cover(const Grid& grid,
                                            const std::vector<std::vector<CellIndex>>& clusters,
                                            const FreeSpace& space, const Passages& ways,
                                            const CoverParams& params);

}  // namespace tandem
