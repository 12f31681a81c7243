// SPDX-License-Identifier: Apache-2.0
// Undistorts a scan: splits it into looks, each from the sensor's pose at that time.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

#include "tandem/map/range_returns.hpp"
#include "tandem/octomap_builder/local_map.hpp"

namespace tandem {

/// X_MS of the sensor at a time [s] after the scan's first beam; nullopt if unknown.
using PoseAfter = std::function<std::optional<Eigen::Isometry3d>(double)>;

/// The scan, split into parts during which the sensor turns by at most 0.01 rad and moves by at
/// most 0.02 m. Without this, at 1 rad/s a 10 Hz scanner would show a wall 5 m away bent by half a
/// metre. nullopt if a pose is unknown. The scan must have no error (error_of).
[[nodiscard]] std::optional<std::vector<Look>> looks_of(const RangeScan& scan,
                                                        const PoseAfter& pose_after,
                                                        const NoReturn& no_return = {});

}  // namespace tandem
