// SPDX-License-Identifier: Apache-2.0
// The topics and services that the runtime opens for every node, besides those of its component.
#pragma once

#include <msgs.hpp>

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

/// All of them, as the node's options open them by default.
[[nodiscard]] TANDEM_EXPORT Interface interface();

}  // namespace tandem::runtime::every_node
