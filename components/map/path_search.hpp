// SPDX-License-Identifier: Apache-2.0
// Finds the path between two points that a person who knows the static map would take.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/static_map.hpp"

namespace tandem {

inline constexpr double kWide = 0.5, kNarrowCost = 8.0;  ///< [m], [1] for path searches

/// Cost of one metre for the centre of a disc of that radius at p_MC [m]: 1 where the rim keeps
/// `kWide` [m] from obstacles, up to 1 + narrow_cost where it comes near them, infinite where the
/// disc does not fit.
[[nodiscard]] double cost_of_a_metre(const StaticMap& map, const Eigen::Vector2d& p_MC,
                                     double radius, double narrow_cost);

/// The cheapest path by cost_of_a_metre for the centre of a disc of that radius, from cell to cell
/// of the grid, with a point about every quarter of a metre and both ends included. A `narrow_cost`
/// of 0 gives the shortest such path. Empty if there is no path.
[[nodiscard]] std::vector<Eigen::Vector2d> find_path(const StaticMap& map,
                                                     const Eigen::Vector2d& p_MA,
                                                     const Eigen::Vector2d& p_MZ, double radius,
                                                     double narrow_cost = kNarrowCost);

/// Whether find_path() finds one, in a fraction of its time.
[[nodiscard]] bool has_path(const StaticMap& map, const Eigen::Vector2d& p_MA,
                            const Eigen::Vector2d& p_MZ, double radius);

}  // namespace tandem
