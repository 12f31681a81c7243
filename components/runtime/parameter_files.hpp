// SPDX-License-Identifier: Apache-2.0
// Reads ROS 2 parameter files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// One value that a parameter file gives to a node.
struct FileValue {
  std::string key;     ///< nested keys joined by '.'
  std::string yaml;    ///< text of the value
  std::string origin;  ///< "robot.yaml:12"
  bool wildcard;       ///< from a section such as `/**`
};

/// A part of a parameter file that names one node.
struct FileSection {
  std::string name;    ///< "/a/b"
  std::string origin;  ///< "robot.yaml:1"
};

/// Sections, with or without wildcards, that match none of these nodes. Throws like
/// read_parameter_file().
[[nodiscard]] TANDEM_EXPORT std::vector<FileSection> sections_for_nobody(
    const std::string& path, const std::vector<std::string>& full_names);

/// The values of `path` for node `full_name`: first those of wildcard sections, then the node's
/// own. Throws std::invalid_argument naming file and line if the format is not ROS 2's.
[[nodiscard]] TANDEM_EXPORT std::vector<FileValue> read_parameter_file(
    const std::string& path, const std::string& full_name);

/// Whether section name `pattern` ("/a/b", "/**", "/**/b", "/*/b") matches node `full_name`.
[[nodiscard]] TANDEM_EXPORT bool matches_node(std::string_view pattern, std::string_view full_name);

}  // namespace tandem::runtime
