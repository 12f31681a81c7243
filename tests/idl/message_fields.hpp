// SPDX-License-Identifier: Apache-2.0
// Defines fill(json, message) for every supported ROS message: each field is read from the member
// of the same name.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <msgs.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tandem::runtime {

template <class T>
requires(!std::is_class_v<T>) void fill(const nlohmann::json& json, T& value) {
  value = json.get<T>();
}

// A string, bounded or not.
template <class T>
requires requires(const T& text) { text.c_str(); }
void fill(const nlohmann::json& json, T& value) { value = json.get<std::string>(); }

template <class M>
requires requires { MessageType<M>::name; }
void fill(const nlohmann::json& json, M& message);

template <class T, size_t N>
void fill(const nlohmann::json& json, std::array<T, N>& values) {
  if (json.size() != N) throw std::runtime_error("array of another size");
  for (size_t i = 0; i < N; ++i) fill(json.at(i), values[i]);
}

template <class T>
void fill(const nlohmann::json& json, std::vector<T>& values) {
  for (const auto& item : json) {
    T value{};
    fill(item, value);
    values.push_back(std::move(value));
  }
}

// FIELDS(type, a, b, …): fill() for `type`; every member of the JSON object must be a field.
#define TANDEM_AGAIN(...) TANDEM_AGAIN1(TANDEM_AGAIN1(TANDEM_AGAIN1(__VA_ARGS__)))
#define TANDEM_AGAIN1(...) TANDEM_AGAIN2(TANDEM_AGAIN2(TANDEM_AGAIN2(__VA_ARGS__)))
#define TANDEM_AGAIN2(...) TANDEM_AGAIN3(TANDEM_AGAIN3(TANDEM_AGAIN3(__VA_ARGS__)))
#define TANDEM_AGAIN3(...) __VA_ARGS__
#define TANDEM_NEXT() TANDEM_FIELD
#define TANDEM_PARENS ()
#define TANDEM_FIELD(field, ...)          \
  fill(json.at(#field), message.field()); \
  ++fields;                               \
  __VA_OPT__(TANDEM_NEXT TANDEM_PARENS(__VA_ARGS__))
#define FIELDS(type, ...)                                                                         \
  template <>                                                                                     \
  inline void fill([[maybe_unused]] const nlohmann::json& json, [[maybe_unused]] type& message) { \
    size_t fields = 0;                                                                            \
    __VA_OPT__(TANDEM_AGAIN(TANDEM_FIELD(__VA_ARGS__)))                                           \
    if (fields != json.size()) throw std::runtime_error("fields of " #type);                      \
  }

FIELDS(builtin_interfaces::msg::Time, sec, nanosec)
FIELDS(builtin_interfaces::msg::Duration, sec, nanosec)
FIELDS(std_msgs::msg::Header, stamp, frame_id)
FIELDS(std_msgs::msg::String, data)
FIELDS(std_msgs::msg::Bool, data)
FIELDS(std_msgs::msg::Float64, data)
FIELDS(std_msgs::msg::ColorRGBA, r, g, b, a)
FIELDS(geometry_msgs::msg::Vector3, x, y, z)
FIELDS(geometry_msgs::msg::Point, x, y, z)
FIELDS(geometry_msgs::msg::Point32, x, y, z)
FIELDS(geometry_msgs::msg::Quaternion, x, y, z, w)
FIELDS(geometry_msgs::msg::Pose, position, orientation)
FIELDS(geometry_msgs::msg::Pose2D, x, y, theta)
FIELDS(geometry_msgs::msg::PoseStamped, header, pose)
FIELDS(geometry_msgs::msg::PoseWithCovariance, pose, covariance)
FIELDS(geometry_msgs::msg::PoseWithCovarianceStamped, header, pose)
FIELDS(geometry_msgs::msg::Twist, linear, angular)
FIELDS(geometry_msgs::msg::TwistStamped, header, twist)
FIELDS(geometry_msgs::msg::TwistWithCovariance, twist, covariance)
FIELDS(geometry_msgs::msg::Transform, translation, rotation)
FIELDS(geometry_msgs::msg::TransformStamped, header, child_frame_id, transform)
FIELDS(geometry_msgs::msg::Polygon, points)
FIELDS(geometry_msgs::msg::PolygonStamped, header, polygon)
FIELDS(nav_msgs::msg::Odometry, header, child_frame_id, pose, twist)
FIELDS(nav_msgs::msg::Path, header, poses)
FIELDS(nav_msgs::msg::MapMetaData, map_load_time, resolution, width, height, origin)
FIELDS(nav_msgs::msg::OccupancyGrid, header, info, data)
FIELDS(sensor_msgs::msg::Joy, header, axes, buttons)
FIELDS(sensor_msgs::msg::JoyFeedback, type, id, intensity)
FIELDS(sensor_msgs::msg::JoyFeedbackArray, array)
FIELDS(sensor_msgs::msg::LaserScan, header, angle_min, angle_max, angle_increment, time_increment,
       scan_time, range_min, range_max, ranges, intensities)
FIELDS(sensor_msgs::msg::PointField, name, offset, datatype, count)
FIELDS(sensor_msgs::msg::PointCloud2, header, height, width, fields, is_bigendian, point_step,
       row_step, data, is_dense)
FIELDS(sensor_msgs::msg::CompressedImage, header, format, data)
FIELDS(visualization_msgs::msg::UVCoordinate, u, v)
FIELDS(visualization_msgs::msg::MeshFile, filename, data)
FIELDS(visualization_msgs::msg::Marker, header, ns, id, type, action, pose, scale, color, lifetime,
       frame_locked, points, colors, texture_resource, texture, uv_coordinates, text, mesh_resource,
       mesh_file, mesh_use_embedded_materials)
FIELDS(visualization_msgs::msg::MarkerArray, markers)
FIELDS(tf2_msgs::msg::TFMessage, transforms)
FIELDS(rosgraph_msgs::msg::Clock, clock)
FIELDS(diagnostic_msgs::msg::KeyValue, key, value)
FIELDS(diagnostic_msgs::msg::DiagnosticStatus, level, name, message, hardware_id, values)
FIELDS(diagnostic_msgs::msg::DiagnosticArray, header, status)
FIELDS(octomap_msgs::msg::Octomap, header, binary, id, resolution, data)
FIELDS(std_srvs::srv::Empty_Request)
FIELDS(std_srvs::srv::Empty_Response)
FIELDS(std_srvs::srv::Trigger_Request)
FIELDS(std_srvs::srv::Trigger_Response, success, message)
FIELDS(std_srvs::srv::SetBool_Request, data)
FIELDS(std_srvs::srv::SetBool_Response, success, message)
FIELDS(rcl_interfaces::msg::Log, stamp, level, name, msg, file, function, line)
FIELDS(rcl_interfaces::msg::LoggerLevel, name, level)
FIELDS(rcl_interfaces::msg::SetLoggerLevelsResult, successful, reason)
FIELDS(rcl_interfaces::msg::ParameterValue, type, bool_value, integer_value, double_value,
       string_value, byte_array_value, bool_array_value, integer_array_value, double_array_value,
       string_array_value)
FIELDS(rcl_interfaces::msg::Parameter, name, value)
FIELDS(rcl_interfaces::msg::FloatingPointRange, from_value, to_value, step)
FIELDS(rcl_interfaces::msg::IntegerRange, from_value, to_value, step)
FIELDS(rcl_interfaces::msg::ParameterDescriptor, name, type, description, additional_constraints,
       read_only, dynamic_typing, floating_point_range, integer_range)
FIELDS(rcl_interfaces::msg::ParameterEvent, stamp, node, new_parameters, changed_parameters,
       deleted_parameters)
FIELDS(rcl_interfaces::msg::SetParametersResult, successful, reason)
FIELDS(rcl_interfaces::msg::ListParametersResult, names, prefixes)
FIELDS(rcl_interfaces::srv::DescribeParameters_Request, names)
FIELDS(rcl_interfaces::srv::DescribeParameters_Response, descriptors)
FIELDS(rcl_interfaces::srv::GetParameterTypes_Request, names)
FIELDS(rcl_interfaces::srv::GetParameterTypes_Response, types)
FIELDS(rcl_interfaces::srv::GetParameters_Request, names)
FIELDS(rcl_interfaces::srv::GetParameters_Response, values)
FIELDS(rcl_interfaces::srv::ListParameters_Request, prefixes, depth)
FIELDS(rcl_interfaces::srv::ListParameters_Response, result)
FIELDS(rcl_interfaces::srv::SetParameters_Request, parameters)
FIELDS(rcl_interfaces::srv::SetParameters_Response, results)
FIELDS(rcl_interfaces::srv::SetParametersAtomically_Request, parameters)
FIELDS(rcl_interfaces::srv::SetParametersAtomically_Response, result)
FIELDS(rcl_interfaces::srv::GetLoggerLevels_Request, names)
FIELDS(rcl_interfaces::srv::GetLoggerLevels_Response, levels)
FIELDS(rcl_interfaces::srv::SetLoggerLevels_Request, levels)
FIELDS(rcl_interfaces::srv::SetLoggerLevels_Response, results)
FIELDS(composition_interfaces::srv::LoadNode_Request, package_name, plugin_name, node_name,
       node_namespace, log_level, remap_rules, parameters, extra_arguments)
FIELDS(composition_interfaces::srv::LoadNode_Response, success, error_message, full_node_name,
       unique_id)
FIELDS(composition_interfaces::srv::UnloadNode_Request, unique_id)
FIELDS(composition_interfaces::srv::UnloadNode_Response, success, error_message)
FIELDS(composition_interfaces::srv::ListNodes_Request)
FIELDS(composition_interfaces::srv::ListNodes_Response, full_node_names, unique_ids)
FIELDS(type_description_interfaces::msg::FieldType, type_id, capacity, string_capacity,
       nested_type_name)
FIELDS(type_description_interfaces::msg::Field, name, type, default_value)
FIELDS(type_description_interfaces::msg::IndividualTypeDescription, type_name, fields)
FIELDS(type_description_interfaces::msg::TypeDescription, type_description,
       referenced_type_descriptions)
FIELDS(type_description_interfaces::msg::TypeSource, type_name, encoding, raw_file_contents)
FIELDS(type_description_interfaces::msg::KeyValue, key, value)
FIELDS(type_description_interfaces::srv::GetTypeDescription_Request, type_name, type_hash,
       include_type_sources)
FIELDS(type_description_interfaces::srv::GetTypeDescription_Response, successful, failure_reason,
       type_description, type_sources, extra_information)
FIELDS(rmw_dds_common::msg::Gid, data)
FIELDS(rmw_dds_common::msg::NodeEntitiesInfo, node_namespace, node_name, reader_gid_seq,
       writer_gid_seq)
FIELDS(rmw_dds_common::msg::ParticipantEntitiesInfo, gid, node_entities_info_seq)

/// Messages with a separate entry in vectors.json.
using RosMessages = testing::Types<
    builtin_interfaces::msg::Time, builtin_interfaces::msg::Duration, std_msgs::msg::Header,
    std_msgs::msg::String, std_msgs::msg::Bool, std_msgs::msg::Float64, std_msgs::msg::ColorRGBA,
    geometry_msgs::msg::Vector3, geometry_msgs::msg::Point, geometry_msgs::msg::Point32,
    geometry_msgs::msg::Quaternion, geometry_msgs::msg::Pose, geometry_msgs::msg::Pose2D,
    geometry_msgs::msg::PoseStamped, geometry_msgs::msg::PoseWithCovariance,
    geometry_msgs::msg::PoseWithCovarianceStamped, geometry_msgs::msg::Twist,
    geometry_msgs::msg::TwistStamped, geometry_msgs::msg::TwistWithCovariance,
    geometry_msgs::msg::Transform, geometry_msgs::msg::TransformStamped,
    geometry_msgs::msg::Polygon, geometry_msgs::msg::PolygonStamped, nav_msgs::msg::Odometry,
    nav_msgs::msg::Path, nav_msgs::msg::MapMetaData, nav_msgs::msg::OccupancyGrid,
    sensor_msgs::msg::Joy, sensor_msgs::msg::JoyFeedback, sensor_msgs::msg::JoyFeedbackArray,
    sensor_msgs::msg::LaserScan, sensor_msgs::msg::PointField, sensor_msgs::msg::PointCloud2,
    visualization_msgs::msg::Marker, visualization_msgs::msg::MarkerArray, tf2_msgs::msg::TFMessage,
    rosgraph_msgs::msg::Clock, diagnostic_msgs::msg::KeyValue,
    diagnostic_msgs::msg::DiagnosticStatus, diagnostic_msgs::msg::DiagnosticArray,
    octomap_msgs::msg::Octomap, std_srvs::srv::Empty_Request, std_srvs::srv::Empty_Response,
    std_srvs::srv::Trigger_Request, std_srvs::srv::Trigger_Response, std_srvs::srv::SetBool_Request,
    std_srvs::srv::SetBool_Response, rcl_interfaces::msg::Log, rcl_interfaces::msg::ParameterValue,
    rcl_interfaces::msg::Parameter, rcl_interfaces::msg::FloatingPointRange,
    rcl_interfaces::msg::IntegerRange, rcl_interfaces::msg::ParameterDescriptor,
    rcl_interfaces::msg::ParameterEvent, rcl_interfaces::msg::SetParametersResult,
    rcl_interfaces::msg::ListParametersResult, rcl_interfaces::srv::DescribeParameters_Request,
    rcl_interfaces::srv::DescribeParameters_Response,
    rcl_interfaces::srv::GetParameterTypes_Request, rcl_interfaces::srv::GetParameterTypes_Response,
    rcl_interfaces::srv::GetParameters_Request, rcl_interfaces::srv::GetParameters_Response,
    rcl_interfaces::srv::ListParameters_Request, rcl_interfaces::srv::ListParameters_Response,
    rcl_interfaces::srv::SetParameters_Request, rcl_interfaces::srv::SetParameters_Response,
    rcl_interfaces::srv::SetParametersAtomically_Request,
    rcl_interfaces::srv::SetParametersAtomically_Response,
    rcl_interfaces::srv::GetLoggerLevels_Request, rcl_interfaces::srv::GetLoggerLevels_Response,
    rcl_interfaces::srv::SetLoggerLevels_Request, rcl_interfaces::srv::SetLoggerLevels_Response,
    composition_interfaces::srv::LoadNode_Request, composition_interfaces::srv::LoadNode_Response,
    composition_interfaces::srv::UnloadNode_Request,
    composition_interfaces::srv::UnloadNode_Response,
    composition_interfaces::srv::ListNodes_Request, composition_interfaces::srv::ListNodes_Response,
    type_description_interfaces::srv::GetTypeDescription_Request,
    type_description_interfaces::srv::GetTypeDescription_Response, rmw_dds_common::msg::Gid,
    rmw_dds_common::msg::NodeEntitiesInfo, rmw_dds_common::msg::ParticipantEntitiesInfo>;

}  // namespace tandem::runtime
