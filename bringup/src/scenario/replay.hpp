// SPDX-License-Identifier: Apache-2.0
// Extracts a driver's joystick input from a recording, so that a scenario can replay it.
#pragma once

#include <string>

#include "tandem/driver/wanderers.hpp"
#include "tandem/teleop/teleop.hpp"

namespace tandem {

/// The joystick input in a recording (a folder of `tandem record` or of rosbag2, or its .mcap or
/// .db3). With `topic` empty, it is taken from the topic named `joy`, or else computed from the one
/// named `cmd_vel_user`; otherwise `topic` is the full name. A released dead-man button counts as a
/// stick at rest. Throws std::runtime_error, one line that names the file, if it is not a
/// recording, if it contains no joystick input, or if `topic` is empty and several topics match.
[[nodiscard]] Recording recorded_stick(const std::string& path, const TeleopParams& teleop,
                                       const std::string& topic = {});

}  // namespace tandem
