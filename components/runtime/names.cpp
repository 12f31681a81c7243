// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/names.hpp"

#include <algorithm>
#include <stdexcept>

#include "tandem/config/printable.hpp"
#include "tandem/runtime/module_mark.hpp"

namespace tandem::runtime {
namespace {

// rmw's limits (rmw/validate_*.h): DDS allows 255 characters, of which rmw reserves 8 for its
// prefixes and suffixes.
constexpr std::size_t kMaxTopic = 247, kMaxNamespace = kMaxTopic - 2, kMaxNode = 255;

// Keeps error messages to one line even for very long names.
std::string shortened(std::string_view name) {
  constexpr std::size_t kShown = 40;
  return name.size() <= kShown ? std::string{name} : std::string{name.substr(0, kShown)} + "…";
}

void check_length(std::string_view name, const char* kind, std::size_t limit) {
  if (name.size() > limit)
    throw std::invalid_argument("'" + shortened(name) + "' is too long for " + kind + ": " +
                                std::to_string(name.size()) + " characters, " +
                                std::to_string(limit) + " are allowed");
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A token: letters, digits and '_', not starting with a digit. ROS 2's design forbids "__" too; its
// code does not.
bool is_token(std::string_view token) {
  if (token.empty() || is_digit(token.front())) return false;
  for (const char c : token)
    if (!is_letter(c) && !is_digit(c)) return false;
  return true;
}

std::string join(const std::string& ns, std::string_view name) {
  return (ns == "/" ? "" : ns) + "/" + std::string{name};
}

std::string replace_all(std::string text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace

bool is_full_name(std::string_view name) {
  if (name.empty() || name.front() != '/') return false;
  while (!name.empty()) {
    name.remove_prefix(1);
    const auto end = std::min(name.find('/'), name.size());
    if (!is_token(name.substr(0, end))) return false;
    name.remove_prefix(end);
  }
  return true;
}

std::string NodeName::full() const { return join(ns, name); }

NodeName make_node_name(const std::string& ns, const std::string& name) {
  NodeName result{ns.empty() || ns.front() != '/' ? "/" + ns : ns, name};
  check_length(name, "a node name", kMaxNode);
  check_length(result.ns, "a namespace", kMaxNamespace);
  if (!is_token(name))
    throw std::invalid_argument(
        "'" + name +
        "' is not a valid node name: use letters, digits and '_', not starting with a digit");
  if (result.ns != "/" && !is_full_name(result.ns))
    throw std::invalid_argument("'" + ns +
                                "' is not a valid namespace: use tokens separated by '/'");
  return result;
}

void check_module_name(const char* kind, const std::string& name) {
  const auto is_lower = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto may_follow = [&](char c) { return is_lower(c) || is_digit(c) || c == '_'; };
  if (!name.empty() && name.size() <= kMaxModuleName && is_lower(name.front()) &&
      std::all_of(name.begin(), name.end(), may_follow))
    return;
  throw std::invalid_argument(
      std::string{kind} + " '" + printable(shortened(name)) +
      "': a name consists of a-z, 0-9 and _, begins with a letter and has at most " +
      std::to_string(kMaxModuleName) + " characters");
}

std::string expand_name(std::string_view name, const NodeName& node) {
  std::string full = replace_all(std::string{name}, "{node}", node.name);
  for (const char* space : {"{ns}", "{namespace}"}) full = replace_all(full, space, node.ns);
  if (full.starts_with("~/"))
    full = node.full() + full.substr(1);
  else if (!full.starts_with('/'))
    full = join(node.ns, full);
  check_length(full, "a topic or service name", kMaxTopic);
  if (!is_full_name(full))
    throw std::invalid_argument("'" + std::string{name} +
                                "' is not a valid topic or service name of node " + node.full() +
                                ": use tokens of letters, digits and '_' separated by '/'");
  return full;
}

std::string resolve_name(std::string_view name, const NodeName& node,
                         const std::map<std::string, std::string>& remappings) {
  const std::string full = expand_name(name, node);
  for (const auto& [from, to] : remappings)
    if (expand_name(from, node) == full) return expand_name(to, node);
  return full;
}

std::string dds_topic_name(const std::string& topic) { return "rt" + topic; }
std::string dds_request_name(const std::string& service) { return "rq" + service + "Request"; }
std::string dds_reply_name(const std::string& service) { return "rr" + service + "Reply"; }

std::string ros_name(const std::string& dds_name) {
  const bool mangled =
      dds_name.starts_with("rt/") || dds_name.starts_with("rq/") || dds_name.starts_with("rr/");
  return mangled ? dds_name.substr(2) : dds_name;
}

std::string ros_type(const std::string& dds_type) {
  std::string type = replace_all(replace_all(dds_type, "::dds_::", "/"), "::", "/");
  if (type.ends_with('_')) type.pop_back();
  return type;
}

std::string dds_type(const std::string& ros_type) {
  const auto first = ros_type.find('/'), last = ros_type.rfind('/');
  const bool three_parts = first != 0 && first != std::string::npos && last > first + 1 &&
                           last + 1 < ros_type.size() && ros_type.find('/', first + 1) == last;
  if (!three_parts)
    throw std::invalid_argument("'" + ros_type +
                                "' is not a type name such as std_msgs/msg/String");
  return ros_type.substr(0, first) + "::" + ros_type.substr(first + 1, last - first - 1) +
         "::dds_::" + ros_type.substr(last + 1) + "_";
}

}  // namespace tandem::runtime
