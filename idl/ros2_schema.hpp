// SPDX-License-Identifier: Apache-2.0
// Definitions of types as the text that tools decode messages by. Not installed.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tandem::runtime {

/// The definition of an IDL type ("pkg/msg/Type", "pkg/srv/Type_Request") in ROS 2's .msg format,
/// followed by the types it contains, as Foxglove and MCAP expect for "ros2msg"; without comments
/// and default values. nullopt as described_type() is null. Thread-safe.
[[nodiscard]] std::optional<std::string> ros2msg(std::string_view type);

}  // namespace tandem::runtime
