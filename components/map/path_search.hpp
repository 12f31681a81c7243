// SPDX-License-Identifier: Apache-2.0
// In: a static map and two points. Out: the way that someone would go who knows the place.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/static_map.hpp"

namespace tandem {

inline constexpr double kWide = 0.5, kNarrowCost = 8.0;

/// What a metre costs the centre of a disc of that radius at p_MC, in metres: up to 1 + narrow_cost
/// where its rim comes near obstacles, 1 where it keeps `kWide` [m] from them; infinite without
/// room.
[[nodiscard]] double cost_of_a_metre(const StaticMap& map, const Eigen::Vector2d& p_MC,
                                     double radius, double narrow_cost);

/// The cheapest way for the centre of a disc of that radius, from cell to cell of the grid, a point
/// about every quarter of a metre; both ends included; by cost_of_a_metre, where a `narrow_cost` of
/// 0 gives the shortest way of its kind. Empty if there is no way.
[[nodiscard]] std::vector<Eigen::Vector2d> find_path(const StaticMap& map,
                                                     const Eigen::Vector2d& p_MA,
                                                     const Eigen::Vector2d& p_MZ, double radius,
                                                     double narrow_cost = kNarrowCost);

}  // namespace tandem
