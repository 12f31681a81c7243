// SPDX-License-Identifier: Apache-2.0
// In: a static map and two points. Out: the way that someone would go who knows the place.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "map/static_map.hpp"

namespace tandem {

/// The cheapest way for the centre of a disc of that radius, from cell to cell of the grid, a point
/// about every quarter of a metre; both ends included. A metre costs up to `narrow_cost` metres
/// more where the disc's rim comes near obstacles than where it keeps `kWide` [m] from them; 0
/// gives the shortest way of its kind. Empty if there is no way.
inline constexpr double kWide = 0.5, kNarrowCost = 8.0;
[[nodiscard]] std::vector<Eigen::Vector2d> find_way(const StaticMap& map,
                                                    const Eigen::Vector2d& p_MA,
                                                    const Eigen::Vector2d& p_MZ, double radius,
                                                    double narrow_cost = kNarrowCost);

}  // namespace tandem
