// SPDX-License-Identifier: Apache-2.0
// In: a scan whose beams were taken one after the other. Out: looks, each from where the robot was.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "tandem/map/range_returns.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/octomap_builder/local_map.hpp"

namespace tandem {

/// X_MB so many seconds after the scan's first beam; nothing if nobody knows.
using PoseAfter = std::function<std::optional<Pose2>(double)>;

/// The scan of a sensor at X_BS, cut into parts in which the robot turns by no more than 0.01 rad
/// and moves by no more than 0.02 m: at 1 rad/s a scanner of 10 Hz would show a wall 5 m away bent
/// by half a metre. Nothing if a pose is not known. The scan must have no error (error_of).
[[nodiscard]] std::optional<std::vector<Look>> looks_of(const RangeScan& scan,
                                                        const Eigen::Isometry3d& X_BS,
                                                        const PoseAfter& pose_after,
                                                        const NoReturn& no_return = {});

}  // namespace tandem
