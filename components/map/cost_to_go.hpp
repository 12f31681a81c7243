// SPDX-License-Identifier: Apache-2.0
// In: a static map and a place. Out: how far it is from anywhere to there, round what stands about.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/path_search.hpp"
#include "tandem/map/static_map.hpp"

namespace tandem {

/// Cost for the centre of a disc to come from any cell of the grid to one place [m], a metre
/// counted by cost_of_a_metre. Solves |∇V| = cost of a metre by the fast marching method (Sethian
/// 1996, first order), so that V is smooth and favours no direction of the grid.
class CostToGo {
 public:
  /// No way leads anywhere if the place is outside of the grid. Cost O(n log n) of the grid's
  /// cells.
  CostToGo(const StaticMap& map, const Eigen::Vector2d& p_MZ, double radius,
           double narrow_cost = kNarrowCost);

  /// V at a point, linear between the cells' centres [m]; infinite where no way is known.
  [[nodiscard]] double at(const Eigen::Vector2d& p_MQ) const;

  /// Heading in M in which V falls fastest; 0 where it is flat or not known.
  [[nodiscard]] double downhill(const Eigen::Vector2d& p_MQ) const;

 private:
  [[nodiscard]] double cost(int ix, int iy) const;

  Eigen::Vector2d origin_;  // of the grid, in M [m]
  double resolution_;       // [m]
  int width_, height_;
  std::vector<float> cost_;  // per cell, at its centre [m]
};

}  // namespace tandem
