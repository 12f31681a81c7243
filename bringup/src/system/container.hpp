// SPDX-License-Identifier: Apache-2.0
// Loads components into this process and unloads them on composition_interfaces requests.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <string>

#include "tandem/runtime/component.hpp"

namespace tandem {

/// The component for a ROS 2 package and plugin name: ("tandem", "tandem::LocalPlanner") and
/// ("tandem_local_planner", "tandem::LocalPlanner") are local_planner. The package is that of the
/// module, Tandem's or a third party's. Throws std::invalid_argument if it does not contain the
/// plugin, and as rt::package_of() does. Loads nothing.
[[nodiscard]] std::string component_of(const std::string& package, const std::string& plugin);

/// Parses a load request. Throws std::invalid_argument for an invalid remap rule or value.
[[nodiscard]] rt::NodeOptions options_of(
    const composition_interfaces::srv::LoadNode_Request& request);

/// Loads and unloads components on request, like rclcpp_components' container. Services:
/// ~/_container/load_node, unload_node, list_nodes.
class Container {
 public:
  explicit Container(rt::Node& node);

 private:
  using LoadRequest = composition_interfaces::srv::LoadNode_Request;
  using LoadResponse = composition_interfaces::srv::LoadNode_Response;

  void load(const LoadRequest& request, LoadResponse& response);
  void unload(std::uint64_t id, composition_interfaces::srv::UnloadNode_Response& response);
  void list(composition_interfaces::srv::ListNodes_Response& response) const;

  rt::Node& node_;
  std::map<std::uint64_t, rt::RunningComponent> components_;
  std::uint64_t last_id_ = 0;
  rt::Service load_, unload_, list_;
};

/// `tandem container`: runs a container until SIGINT or SIGTERM.
void add_container_command(CLI::App& app);

}  // namespace tandem
