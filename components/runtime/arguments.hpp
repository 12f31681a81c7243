// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/runtime/node.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Parsed `--ros-args … [--]` of a command line. In `remappings` and `parameters` the entry ""
/// applies to every node.
struct RosArguments {
  std::map<std::string, std::map<std::string, std::string>> remappings;  ///< node → from → to
  std::map<std::string, std::map<std::string, std::string>> parameters;  ///< node → key → value
  std::vector<std::string> parameter_files;    ///< of --params-file, in order
  std::map<std::string, LogLevel> log_levels;  ///< by logger name ("node", "ns.node")
  bool rosout = true;                          ///< whether nodes log to /rosout
  std::vector<std::string> rest;               ///< the arguments that are not ROS's
};

/// Applies the enclave, the log level and the stderr switch to the process immediately. Throws
/// std::invalid_argument for an argument that ROS 2 would reject.
[[nodiscard]] TANDEM_EXPORT RosArguments
parse_ros_arguments(const std::vector<std::string>& arguments);

/// Node names in the rules that match none of `nodes`; those rules have no effect. Rules match the
/// node's name before remapping; parameter rules also match the name after it.
[[nodiscard]] TANDEM_EXPORT std::vector<std::string> strangers_in(
    const RosArguments& arguments, const std::vector<NodeOptions>& nodes);

/// `options` overridden by the command line (including `__node`, `__name` and `__ns`).
[[nodiscard]] TANDEM_EXPORT NodeOptions with_arguments(NodeOptions options,
                                                       const RosArguments& arguments);

}  // namespace tandem::runtime
