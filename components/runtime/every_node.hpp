// SPDX-License-Identifier: Apache-2.0
// The topics, services and parameters of every node, besides those of its component.
#pragma once

#include <string>

#include <msgs.hpp>

#include "tandem/config/params.hpp"
#include "tandem/runtime/interface.hpp"
#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime::every_node {

/// QoS of the parameter services and of /parameter_events, as in rclcpp.
inline constexpr QoS kParameters{.depth = 1000};
/// As rcl_qos_profile_rosout_default: the lifespan limits late consoles to recent lines.
inline constexpr QoS kRosOut{Reliability::kReliable, Durability::kTransientLocal, 1000, 10.0};

/// Read under use_sim_time.
inline constexpr Topic<rosgraph_msgs::msg::Clock> clock{"/clock", kClock};
/// The node's log.
inline constexpr Topic<rcl_interfaces::msg::Log> rosout{"/rosout", kRosOut};
/// Changes of its parameters.
inline constexpr Topic<rcl_interfaces::msg::ParameterEvent> parameter_events{"/parameter_events",
                                                                             kParameters};
/// Its health.
inline constexpr Topic<diagnostic_msgs::msg::DiagnosticArray> diagnostics{"/diagnostics"};

/// Meaning, type and bounds of parameters.
inline constexpr ServiceName<rcl_interfaces::srv::DescribeParameters> describe_parameters{
    "~/describe_parameters"};
/// Types of parameters.
inline constexpr ServiceName<rcl_interfaces::srv::GetParameterTypes> get_parameter_types{
    "~/get_parameter_types"};
/// Values of parameters.
inline constexpr ServiceName<rcl_interfaces::srv::GetParameters> get_parameters{"~/get_parameters"};
/// Names of parameters.
inline constexpr ServiceName<rcl_interfaces::srv::ListParameters> list_parameters{
    "~/list_parameters"};
/// Sets parameters one by one.
inline constexpr ServiceName<rcl_interfaces::srv::SetParameters> set_parameters{"~/set_parameters"};
/// Sets all or none.
inline constexpr ServiceName<rcl_interfaces::srv::SetParametersAtomically>
    set_parameters_atomically{"~/set_parameters_atomically"};
/// Levels of loggers.
inline constexpr ServiceName<rcl_interfaces::srv::GetLoggerLevels> get_logger_levels{
    "~/get_logger_levels"};
/// Sets levels of loggers.
inline constexpr ServiceName<rcl_interfaces::srv::SetLoggerLevels> set_logger_levels{
    "~/set_logger_levels"};
/// The definition of a message type.
inline constexpr ServiceName<type_description_interfaces::srv::GetTypeDescription>
    get_type_description{"~/get_type_description"};

/// All topics and services, as the node's options open them by default.
[[nodiscard]] TANDEM_EXPORT Interface interface();

/// Parameters that every node has: those of rclcpp, and those that enable introspection under the
/// names that ROS 2's demos give them.
struct Params {
  /// Name of the parameter that selects the clock.
  static constexpr const char* kUseSimTime = "use_sim_time";
  /// Name of the parameter that only counts at the start.
  static constexpr const char* kTypeDescriptionService = "start_type_description_service";

  bool use_sim_time = false;                   ///< time from /clock
  bool start_type_description_service = true;  ///< serves ~/get_type_description
  // What is published of requests and responses: "disabled", "metadata" or "contents".
  std::string service_introspection = "disabled";        ///< of services it serves
  std::string client_introspection = "disabled";         ///< of services it calls
  std::string action_server_introspection = "disabled";  ///< of actions it serves
  std::string action_client_introspection = "disabled";  ///< of actions it calls

  /// Calls `field` with the name, value, limits and meaning of each.
  template <class Visitor>
  void visit(Visitor&& field) {
    const OneOf states{{"disabled", "metadata", "contents"}};
    field(kUseSimTime, use_sim_time, "true: the time is taken from /clock");
    field(kTypeDescriptionService, start_type_description_service,
          "whether the node serves ~/get_type_description");
    field("service_configure_introspection", service_introspection, states,
          "what it publishes of the requests to its services and of its responses");
    field("client_configure_introspection", client_introspection, states,
          "what it publishes of its requests to services and of their responses");
    field("action_server_configure_introspection", action_server_introspection, states,
          "what it publishes of the requests to its actions and of its responses");
    field("action_client_configure_introspection", action_client_introspection, states,
          "what it publishes of its requests to actions and of their responses");
  }
};

}  // namespace tandem::runtime::every_node
