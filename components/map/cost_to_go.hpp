// SPDX-License-Identifier: Apache-2.0
// Computes the cost of the cheapest path from anywhere in a static map to one point.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/path_search.hpp"
#include "tandem/map/static_map.hpp"

namespace tandem {

/// Cost for the centre of a disc to move from any cell of the grid to one point [m]; each metre is
/// weighted by cost_of_a_metre. Solves |∇V| = cost of a metre by the fast marching method (Sethian
/// 1996, first order), so V is smooth and has no preferred direction of the grid.
class CostToGo {
 public:
  /// The goal p_MZ; every cost is infinite if it is outside the grid. Takes O(n log n) in the
  /// number of cells.
  CostToGo(const StaticMap& map, const Eigen::Vector2d& p_MZ, double radius,
           double narrow_cost = kNarrowCost);

  /// V at a point, interpolated linearly between cell centres [m]; infinite where no path is known.
  [[nodiscard]] double at(const Eigen::Vector2d& p_MQ) const;

  /// Heading in M of the steepest descent of V [rad]; 0 where V is flat or unknown.
  [[nodiscard]] double downhill(const Eigen::Vector2d& p_MQ) const;

 private:
  [[nodiscard]] double cost(int ix, int iy) const;

  Eigen::Vector2d origin_;  // of the grid, in M [m]
  double resolution_;       // [m]
  int width_, height_;
  std::vector<float> cost_;  // per cell, at its centre [m]
};

}  // namespace tandem
