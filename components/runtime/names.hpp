// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// A node's namespace and name, against which relative and private names are resolved.
struct NodeName {
  std::string ns;    ///< "/" or "/a/b"
  std::string name;  ///< "planner"

  /// "/planner" or "/a/b/planner".
  [[nodiscard]] TANDEM_EXPORT std::string full() const;
};

/// Whether the name has the form "/a/b" (tokens of letters, digits and '_' after slashes). DDS
/// programs outside ROS 2 may use other names.
[[nodiscard]] TANDEM_EXPORT bool is_full_name(std::string_view name);

/// Throws std::invalid_argument unless both follow ROS 2's rules (at most 255 characters, the
/// namespace 245); "a" as namespace means "/a".
[[nodiscard]] TANDEM_EXPORT NodeName make_node_name(const std::string& ns, const std::string& name);

/// Throws std::invalid_argument unless `name`, the name of a `kind` ("component", "package"), has
/// the form [a-z][a-z0-9_]* and at most 63 characters. A file's name that is made of it lies in the
/// intended folder.
TANDEM_EXPORT void check_module_name(const char* kind, const std::string& name);

/// Absolute form of "/x", "x" or "~/x"; substitutes {node}, {ns} and {namespace}. Throws
/// std::invalid_argument for a name that ROS 2 would reject (letters, digits, '_', '/'; no token
/// starts with a digit; at most 247 characters).
[[nodiscard]] TANDEM_EXPORT std::string expand_name(std::string_view name, const NodeName& node);

/// expand_name(), then the first remapping whose expanded left side equals the result.
[[nodiscard]] TANDEM_EXPORT std::string resolve_name(
    std::string_view name, const NodeName& node,
    const std::map<std::string, std::string>& remappings);

/// DDS names of a ROS 2 topic "/a": "rt/a"; of a service: "rq/aRequest", "rr/aReply".
[[nodiscard]] TANDEM_EXPORT std::string dds_topic_name(const std::string& topic);
/// The DDS topic of a service's requests.
[[nodiscard]] TANDEM_EXPORT std::string dds_request_name(const std::string& service);
/// The DDS topic of a service's responses.
[[nodiscard]] TANDEM_EXPORT std::string dds_reply_name(const std::string& service);

/// ROS 2 form for display: "rt/a" → "/a", "a::msg::dds_::B_" → "a/msg/B".
[[nodiscard]] TANDEM_EXPORT std::string ros_name(const std::string& dds_name);
/// ROS 2's name of a type, for display.
[[nodiscard]] TANDEM_EXPORT std::string ros_type(const std::string& dds_type);
/// "a/msg/B" → "a::msg::dds_::B_". Throws std::invalid_argument if it is not a type name.
[[nodiscard]] TANDEM_EXPORT std::string dds_type(const std::string& ros_type);

}  // namespace tandem::runtime
