// SPDX-License-Identifier: Apache-2.0
// Undistorts a scan: splits it into looks, each from the robot's pose at that time.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "tandem/map/range_returns.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/octomap_builder/local_map.hpp"

namespace tandem {

/// X_MB at a time [s] after the scan's first beam; nullopt if unknown.
using PoseAfter = std::function<std::optional<Pose2>(double)>;

/// The scan of a sensor at X_BS, split into parts during which the robot turns by at most 0.01 rad
/// and moves by at most 0.02 m. Without this, at 1 rad/s a 10 Hz scanner would show a wall 5 m away
/// bent by half a metre. nullopt if a pose is unknown. The scan must have no error (error_of).
[[nodiscard]] std::optional<std::vector<Look>> looks_of(const RangeScan& scan,
                                                        const Eigen::Isometry3d& X_BS,
                                                        const PoseAfter& pose_after,
                                                        const NoReturn& no_return = {});

}  // namespace tandem
