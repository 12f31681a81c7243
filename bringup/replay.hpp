// SPDX-License-Identifier: Apache-2.0
// In: a recording with somebody at the stick. Out: the stick.
#pragma once

#include <string>

#include "driver/wanderers.hpp"
#include "teleop/teleop.hpp"

namespace tandem {

/// The stick of the first topic called `joy` in a recording (a folder of `tandem record` or of
/// rosbag2, or its .db3), or, if there is none, what it must have been for `cmd_vel_user`. A
/// released dead-man button is a stick at rest. Throws std::runtime_error, one line that names the
/// file, if it is no recording or nobody is at the stick.
[[nodiscard]] Recording recorded_stick(const std::string& path, const TeleopParams& teleop);

}  // namespace tandem
