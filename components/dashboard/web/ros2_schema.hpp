// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tandem {

/// The definition of an IDL type ("pkg/msg/Type", "pkg/srv/Type_Request") in ROS 2's .msg format,
/// followed by the types it contains, as Foxglove and MCAP expect for "ros2msg". nullopt for a type
/// that is not in the IDL.
[[nodiscard]] std::optional<std::string> ros2msg(std::string_view type);

}  // namespace tandem
