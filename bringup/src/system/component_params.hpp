// SPDX-License-Identifier: Apache-2.0
// Lists every component with its parameters, for code that handles all components.
#pragma once

#include "tandem/arbitration/arbitration_node.hpp"
#include "tandem/dashboard/dashboard_node.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/driver/driver_node.hpp"
#include "tandem/haptics/haptics_node.hpp"
#include "tandem/hindsight/hindsight_node.hpp"
#include "tandem/joystick/joystick_node.hpp"
#include "tandem/local_planner/local_planner_node.hpp"
#include "tandem/map_server/map_server_node.hpp"
#include "tandem/obstacle_extractor/obstacle_extractor_node.hpp"
#include "tandem/octomap_builder/octomap_builder_node.hpp"
#include "tandem/safety_filter/safety_filter_node.hpp"
#include "tandem/shared_dwa/shared_dwa_node.hpp"
#include "tandem/teleop/teleop_node.hpp"

namespace tandem {

/// Calls `visit(name, params)` for each component, with its default parameters.
template <class Visit>
void for_each_component(Visit&& visit) {
  visit("arbitration", ArbitrationNodeParams{});
  visit("dashboard", DashboardParams{});
  visit("diff_drive_sim", DiffDriveSimNodeParams{});
  visit("driver", DriverNodeParams{});
  visit("haptics", HapticsNodeParams{});
  visit("hindsight", HindsightNodeParams{});
  visit("joystick", JoystickNodeParams{});
  visit("local_planner", LocalPlannerNodeParams{});
  visit("map_server", MapServerParams{});
  visit("obstacle_extractor", ObstacleExtractorNodeParams{});
  visit("octomap_builder", OctomapBuilderNodeParams{});
  visit("safety_filter", SafetyFilterNodeParams{});
  visit("shared_dwa", SharedDwaNodeParams{});
  visit("teleop", TeleopNodeParams{});
}

}  // namespace tandem
