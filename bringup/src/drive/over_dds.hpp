// SPDX-License-Identifier: Apache-2.0
// Runs a scenario with the real nodes over DDS and measures it from their topics alone.
#pragma once

#include <functional>

#include "bringup/drive/drive_log.hpp"

namespace tandem {

/// Runs each component as a separate node. Ends when the goal is reached, the scenario's time is
/// up, `end_sim` is received, or the process is told to stop. Throws what the components'
/// constructors throw, and std::runtime_error if the drive does not begin within 20 s or the robot
/// publishes no ground truth for 5 s.
[[nodiscard]] DriveLog drive_over_dds(const Scenario& scenario, const DriveOptions& options,
                                      const std::function<void(const Progress&)>& progress = {});

}  // namespace tandem
