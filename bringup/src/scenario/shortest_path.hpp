// SPDX-License-Identifier: Apache-2.0
// In: a map, a robot, from where to where. Out: how long the way is at least.
#pragma once

#include <optional>

#include "bringup/scenario/scenario.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Length [m] of the shortest way of the largest disc about base_link's origin inside one part of
/// the outline, from the start to where the goal is reached: the shortest way along the grid,
/// pulled taut. Empty if the goal is no place or there is no way, or if the origin lies on the edge
/// of every part that contains it.
[[nodiscard]] std::optional<double> shortest_path(const StaticMap& map, const Footprint& footprint,
                                                  const Pose2& start, const Goal& goal);

/// What the measures of a drive are relative to, given the shortest way to its goal.
[[nodiscard]] MetricsSetting metrics_setting(const Scenario& scenario, const System& system,
                                             std::optional<double> shortest_path);

}  // namespace tandem
