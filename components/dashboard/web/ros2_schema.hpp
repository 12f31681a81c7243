// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tandem {

/// A type of the IDL ("pkg/msg/Type", "pkg/srv/Type_Request") as ROS 2 writes it in .msg files,
/// the types that it is made of behind it, as Foxglove and MCAP want their "ros2msg". Nothing for
/// a type that is not ours.
[[nodiscard]] std::optional<std::string> ros2msg(std::string_view type);

}  // namespace tandem
