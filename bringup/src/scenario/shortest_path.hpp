// SPDX-License-Identifier: Apache-2.0
// Computes a lower bound on the path length of a robot from a start to a goal in a map.
#pragma once

#include <optional>

#include "bringup/scenario/scenario.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Length [m] of the shortest path from the start to where the goal is reached, for the largest
/// disc centered at base_link's origin inside one part of the outline: the shortest grid path,
/// pulled taut. Empty if the goal has no place or there is no path, or if the origin lies on the
/// edge of every part that contains it.
[[nodiscard]] std::optional<double> shortest_path(const StaticMap& map, const Footprint& footprint,
                                                  const Pose2& start, const Goal& goal);

/// The reference values for a drive's metrics, given the shortest path to its goal.
[[nodiscard]] MetricsSetting metrics_setting(const Scenario& scenario, const System& system,
                                             std::optional<double> shortest_path);

}  // namespace tandem
