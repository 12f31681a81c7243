// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/container.hpp"

#include <cctype>
#include <stdexcept>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "tandem/runtime/arguments.hpp"
#include "tandem/runtime/names.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

using rcl_interfaces::msg::Parameter;
using rcl_interfaces::msg::ParameterValue;

namespace srv = composition_interfaces::srv;

constexpr rt::ServiceName<srv::LoadNode> kLoad{"~/_container/load_node"};
constexpr rt::ServiceName<srv::UnloadNode> kUnload{"~/_container/unload_node"};
constexpr rt::ServiceName<srv::ListNodes> kList{"~/_container/list_nodes"};

// "tandem::LocalPlanner" → "local_planner".
std::string snake_case(const std::string& plugin) {
  const auto colon = plugin.rfind(':');
  std::string name;
  for (const char c : plugin.substr(colon == std::string::npos ? 0 : colon + 1)) {
    const bool upper = std::isupper(static_cast<unsigned char>(c)) != 0;
    if (upper && !name.empty()) name += '_';
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

template <class T>
std::string list(const std::vector<T>& values) {
  YAML::Emitter out;
  out << YAML::Flow << values;
  return out.c_str();
}

// Quoted so that "1" remains a string.
std::string quoted(const std::string& text) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << text;
  return out.c_str();
}

std::string number(double value) {
  YAML::Emitter out;
  out << value;
  return out.c_str();
}

std::string yaml_of(const Parameter& parameter) {
  namespace type = rcl_interfaces::msg::ParameterType_Constants;
  const ParameterValue& value = parameter.value();
  switch (value.type()) {
    case type::PARAMETER_BOOL:
      return value.bool_value() ? "true" : "false";
    case type::PARAMETER_INTEGER:
      return std::to_string(value.integer_value());
    case type::PARAMETER_DOUBLE:
      return number(value.double_value());
    case type::PARAMETER_STRING:
      return quoted(value.string_value());
    case type::PARAMETER_INTEGER_ARRAY:
      return list(value.integer_array_value());
    case type::PARAMETER_DOUBLE_ARRAY:
      return list(value.double_array_value());
    default:
      throw std::invalid_argument(
          "parameter '" + parameter.name() +
          "': no parameter here is unset, of bytes, or a list of strings or "
          "truths");
  }
}

// rclcpp's containers accept these two arguments. There is no intra-process transport here, and a
// component gets only the arguments in its request, which is rclcpp's default.
void check_extra(const Parameter& extra) {
  if (extra.name() == "use_intra_process_comms") return;
  if (extra.name() == "forward_global_arguments") {
    if (!extra.value().bool_value()) return;
    throw std::invalid_argument(
        "forward_global_arguments: true is not done here; give remap rules and parameters in the "
        "request");
  }
  throw std::invalid_argument(
      "extra argument '" + extra.name() +
      "' is not one of {use_intra_process_comms, forward_global_arguments}");
}

}  // namespace

std::string component_of(const std::string& package, const std::string& plugin) {
  rt::check_module_name("package", package);
  const std::string name = snake_case(plugin);
  const std::string owner = rt::package_of(name);
  if (package != owner && package != owner + "_" + name)
    throw std::invalid_argument("package '" + package + "' has no plugin '" + plugin +
                                "'; package '" + owner + "' has it");
  return name;
}

rt::NodeOptions options_of(const srv::LoadNode_Request& request) {
  rt::NodeOptions options;
  options.name = request.node_name().empty()
                     ? component_of(request.package_name(), request.plugin_name())
                     : request.node_name();
  if (!request.node_namespace().empty()) options.ns = request.node_namespace();
  for (const auto& parameter : request.parameters())
    options.parameters.overrides[parameter.name()] = {yaml_of(parameter), "load_node"};
  for (const auto& extra : request.extra_arguments()) check_extra(extra);
  std::vector<std::string> rules{"--ros-args"};
  for (const auto& rule : request.remap_rules()) rules.insert(rules.end(), {"-r", rule});
  return rt::with_arguments(std::move(options), rt::parse_ros_arguments(rules));
}

Container::Container(rt::Node& node)
    : node_{node},
      load_{node.create_service(
          kLoad, [this](const auto& request, auto& response) { load(request, response); })},
      unload_{node.create_service(
          kUnload,
          [this](const auto& request, auto& response) { unload(request.unique_id(), response); })},
      list_{node.create_service(kList, [this](const auto&, auto& response) { list(response); })} {}

void Container::load(const LoadRequest& request, LoadResponse& response) {
  try {
    auto component = rt::load_component(component_of(request.package_name(), request.plugin_name()),
                                        options_of(request));
    response.full_node_name(component.node().fully_qualified_name());
    response.unique_id(++last_id_);
    response.success(true);
    components_.emplace(last_id_, std::move(component));
    node_.log().info("loaded {} as {}", request.plugin_name(), response.full_node_name());
  } catch (const std::exception& error) {
    response.success(false);
    response.error_message(error.what());
    node_.log().error("not loaded: {}", error.what());
  }
}

void Container::unload(std::uint64_t id, srv::UnloadNode_Response& response) {
  const auto found = components_.find(id);
  if (found == components_.end()) {
    response.success(false);
    response.error_message("No node found with unique_id: " + std::to_string(id));
    return;
  }
  const std::string name = found->second.node().fully_qualified_name();
  components_.erase(found);
  response.success(true);
  node_.log().info("unloaded {}", name);
}

void Container::list(srv::ListNodes_Response& response) const {
  for (const auto& [id, component] : components_) {
    response.full_node_names().push_back(component.node().fully_qualified_name());
    response.unique_ids().push_back(id);
  }
}

void add_container_command(CLI::App& app) {
  auto* command = app.add_subcommand(
      "container", "Load components by request, as `ros2 component load` makes them");
  command->allow_extras();  // --ros-args …
  command->footer(
      "The container's node is /tandem_container; --ros-args -r __node:=NAME renames it.");
  command->callback([command] {
    const auto arguments = rt::parse_ros_arguments(command->remaining());
    if (!arguments.rest.empty())
      throw std::invalid_argument("unknown argument '" + arguments.rest.front() + "'");
    rt::install_signal_handlers();
    rt::Node node{rt::with_arguments({.name = "tandem_container"}, arguments)};
    const Container container{node};
    node.log().info("waits for components: ros2 component load {} tandem tandem::LocalPlanner",
                    node.fully_qualified_name());
    node.spin();
  });
}

}  // namespace tandem
