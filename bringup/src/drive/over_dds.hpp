// SPDX-License-Identifier: Apache-2.0
// In: a scenario. Out: its drive by the real nodes over DDS, watched from outside by topics alone.
#pragma once

#include <functional>

#include "bringup/drive/drive_log.hpp"

namespace tandem {

/// Runs every component as a node of its own and listens to them. Ends when the goal is reached,
/// the scenario's time is over, `end_sim` is heard, or the process is told to stop. Throws what the
/// components' constructors throw, and std::runtime_error if the system does not come to life.
[[nodiscard]] DriveLog drive_over_dds(const Scenario& scenario, const DriveOptions& options,
                                      const std::function<void(const Progress&)>& progress = {});

}  // namespace tandem
