// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/unused_remappings.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "tandem/config/nearest_name.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem {
namespace {

using Names = std::set<std::string>;

Names names_in(const rt::Interface& interface) {
  Names names;
  const auto take = [&](const auto& uses) {
    for (const auto& use : uses) names.insert(use.name);
  };
  take(interface.subscribes);
  take(interface.publishes);
  take(interface.serves);
  take(interface.calls);
  take(interface.serves_actions);
  take(interface.calls_actions);
  return names;
}

// A node of a system, and the names that it opens, as its component writes them.
struct NamedNode {
  std::string file_name;  // the node's name in the system file
  std::string component;
  rt::NodeName name;
  std::optional<Names> opens;  // nullopt: any

  [[nodiscard]] bool has(const std::string& from) const {
    if (!opens) return true;
    const std::string full = rt::expand_name(from, name);
    return std::any_of(opens->begin(), opens->end(), [&](const std::string& opened) {
      return rt::expand_name(opened, name) == full;
    });
  }
};

// `tandem run` reports why a module cannot be loaded.
std::optional<Names> names_of(const std::string& component) {
  try {
    Names names = names_in(rt::description_of(component).interface);
    if (names.contains("*")) return std::nullopt;
    names.merge(names_in(rt::every_node::interface()));
    return names;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

// `__node` and `__ns` rename the node itself.
bool renames_node(const std::string& from) { return from.starts_with("__"); }

// The nodes that a rule of the command line applies to; all for the empty name.
std::vector<NamedNode> of_name(const std::vector<NamedNode>& nodes, const std::string& name) {
  std::vector<NamedNode> some;
  for (const auto& node : nodes)
    if (name.empty() || node.file_name == name) some.push_back(node);
  return some;
}

std::string complaint(const std::string& where, const std::string& from,
                      const std::vector<NamedNode>& nodes) {
  Names all;
  for (const auto& node : nodes) all.insert(node.opens->begin(), node.opens->end());
  const std::string nobody =
      nodes.size() == 1 ? nodes.front().component + " has no" : "no node has a";
  return fmt::format("{}: remapping `{}` has no effect: {} topic, service or action of that name{}",
                     where, from, nobody, did_you_mean(from, all));
}

}  // namespace

std::vector<std::string> unused_remappings(const System& system,
                                           const rt::RosArguments& arguments) {
  std::vector<std::string> lines;
  std::vector<NamedNode> nodes;
  const auto check = [&](const std::string& where, const std::string& from,
                         const std::vector<NamedNode>& its) {
    const auto has_it = [&](const NamedNode& node) { return node.has(from); };
    if (!its.empty() && !renames_node(from) && std::none_of(its.begin(), its.end(), has_it))
      lines.push_back(complaint(where, from, its));
  };
  for (const auto& node : system.nodes) {
    const auto options = rt::with_arguments(node.options, arguments);
    nodes.push_back({node.options.name, node.component,
                     rt::make_node_name(options.ns, options.name), names_of(node.component)});
    for (const auto& [from, to] : node.options.remappings)
      check(system.path + ": " + node.options.name, from, {nodes.back()});
  }
  for (const auto& [name, rules] : arguments.remappings)
    for (const auto& [from, to] : rules)
      check("--ros-args -r " + (name.empty() ? from : name + ":" + from) + ":=" + to, from,
            of_name(nodes, name));
  return lines;
}

}  // namespace tandem
