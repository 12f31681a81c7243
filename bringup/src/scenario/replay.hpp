// SPDX-License-Identifier: Apache-2.0
// In: a recording with somebody at the stick. Out: the stick.
#pragma once

#include <string>

#include "tandem/driver/wanderers.hpp"
#include "tandem/teleop/teleop.hpp"

namespace tandem {

/// The stick of a recording (a folder of `tandem record` or of rosbag2, or its .db3): of the topic
/// of that full name, else of the one called `joy`, or, if there is none, what it must have been
/// for the one called `cmd_vel_user`. A released dead-man button is a stick at rest. Throws
/// std::runtime_error, one line that names the file, if it is no recording, if nobody is at the
/// stick, or if no name is given and several topics are called so.
[[nodiscard]] Recording recorded_stick(const std::string& path, const TeleopParams& teleop,
                                       const std::string& topic = {});

}  // namespace tandem
