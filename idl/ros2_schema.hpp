// SPDX-License-Identifier: Apache-2.0
// Definitions of types as the text that tools decode messages by. Not installed.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tandem::runtime {

/// The definition of an IDL type ("pkg/msg/Type", "pkg/srv/Type_Request") in ROS 2's .msg format,
/// followed by the types it contains, as Foxglove and MCAP expect for "ros2msg"; without comments.
/// nullopt as described_type() is null. Thread-safe.
[[nodiscard]] std::optional<std::string> ros2msg(std::string_view type);

/// The definition of the type alone, as in its .msg file. nullopt as described_type() is null.
[[nodiscard]] std::optional<std::string> msg_file(std::string_view type);

}  // namespace tandem::runtime
