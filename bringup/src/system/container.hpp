// SPDX-License-Identifier: Apache-2.0
// In: composition_interfaces' requests. Out: components, loaded into this process and unloaded.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <string>

#include "tandem/runtime/component.hpp"

namespace tandem {

/// The component that a ROS 2 user means by a package and a plugin: ("tandem_local_planner",
/// "tandem::LocalPlanner") and ("tandem", "tandem::LocalPlanner") are local_planner. Throws
/// std::invalid_argument for a package that is not ours or that holds no such plugin.
[[nodiscard]] std::string component_of(const std::string& package, const std::string& plugin);

/// What a request asks for. Throws std::invalid_argument for a remap rule or a value that cannot
/// be.
[[nodiscard]] rt::NodeOptions options_of(
    const composition_interfaces::srv::LoadNode_Request& request);

/// Loads and unloads components by request, as rclcpp_components' container does. Services:
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

/// `tandem container`: a container until SIGINT or SIGTERM.
void add_container_command(CLI::App& app);

}  // namespace tandem
