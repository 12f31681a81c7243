// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/runtime/node.hpp"

namespace tandem::runtime {

/// What `--ros-args … [--]` of a command line says. The entry "" of `rules` holds for every node.
struct RosArguments {
  std::map<std::string, std::map<std::string, std::string>> remappings;  ///< node → from → to
  std::map<std::string, std::map<std::string, std::string>> parameters;  ///< node → key → value
  std::vector<std::string> parameter_files;
  std::map<std::string, LogLevel> log_levels;  ///< of a node's logger ("node", "ns.node")
  bool rosout = true;                          ///< whether nodes log to /rosout
  std::vector<std::string> rest;               ///< the arguments that are not ROS's
};

/// The process's enclave, log level and whether it logs to stderr are set at once. Throws
/// std::invalid_argument for an argument that ROS 2 would not understand.
[[nodiscard]] RosArguments parse_ros_arguments(const std::vector<std::string>& arguments);

/// The nodes that rules name and that are none of these: with those rules nothing is done. A rule
/// holds under the name a node has before remapping; a parameter's also under the name after it.
[[nodiscard]] std::vector<std::string> strangers_in(const RosArguments& arguments,
                                                    const std::vector<NodeOptions>& nodes);

/// `options` with what the command line says laid over it (`__node`, `__name` and `__ns` too).
[[nodiscard]] NodeOptions with_arguments(NodeOptions options, const RosArguments& arguments);

}  // namespace tandem::runtime
