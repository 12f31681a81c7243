// SPDX-License-Identifier: Apache-2.0
// Defines the name, type and QoS of every topic, service and action, in data-flow order. Names are
// relative, so that a namespace applies to a whole robot; all can be remapped.
#pragma once

#include <msgs.hpp>

#include "tandem/runtime/action.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/pubsub.hpp"
#include "tandem/runtime/service.hpp"

namespace tandem::topics {

using runtime::Accepts;
using runtime::kDefault;
using runtime::kLatched;
using runtime::kSensorData;
using runtime::Topic;

/// QoS of velocity commands: only the newest, and none that the network delayed beyond the
/// lifespan.
inline constexpr runtime::QoS kCommand{.depth = 1, .lifespan = 0.2};

// the person
/// The stick: a gamepad, the page or the keys.
inline constexpr Topic<sensor_msgs::msg::Joy> joy{"joy"};
/// Rumble, 0 … 1.
inline constexpr Topic<sensor_msgs::msg::JoyFeedback> joy_feedback{"joy/set_feedback"};
/// The person's command.
inline constexpr Topic<geometry_msgs::msg::Twist> cmd_vel_user{"cmd_vel_user", kCommand};
/// The person's command as corrected by `hindsight`; replaces cmd_vel_user as the planner's input.
inline constexpr Topic<geometry_msgs::msg::Twist> cmd_vel_assisted{"cmd_vel_assisted", kCommand};
/// The goals and their probabilities.
inline constexpr Topic<visualization_msgs::msg::MarkerArray> hindsight_markers{"hindsight/markers"};
/// The leader, a virtual robot that the person drives.
inline constexpr Topic<geometry_msgs::msg::PoseStamped> leader_pose{"leader_pose"};
/// The leader, to be looked at.
inline constexpr Topic<visualization_msgs::msg::MarkerArray> leader_markers{"leader/markers"};
/// Why a deflected stick does not move the robot; empty once it does. Repeated while that lasts.
inline constexpr Topic<std_msgs::msg::String> teleop_status{"teleop/status"};
/// True ends a scenario.
inline constexpr Topic<std_msgs::msg::Bool> end_sim{"end_sim"};
/// QoS for reading user input: best effort, which matches every device's publisher.
inline constexpr runtime::QoS kUserInput{
    .reliability = runtime::Reliability::kBestEffort, .depth = 1, .lifespan = 0.2};
/// The same for joy, with a queue: teleop must see every sample at rest, so the next sample must
/// not overwrite it.
inline constexpr runtime::QoS kStickInput{
    .reliability = runtime::Reliability::kBestEffort, .depth = 10, .lifespan = 0.2};

// the map
/// The finished map.
inline constexpr Topic<octomap_msgs::msg::Octomap> octomap_binary{"octomap_binary", kLatched,
                                                                  Accepts::kEvery};
/// What the sensors see around the robot; not latched, because it is soon outdated.
inline constexpr Topic<octomap_msgs::msg::Octomap> octomap_local{
    "octomap_local", {runtime::Reliability::kReliable, runtime::Durability::kVolatile, 1}};
/// Status of the sensors behind octomap_local, from the node that publishes the latter.
inline constexpr Topic<tandem_msgs::msg::SensingStatus> sensing_status{
    "sensing_status", {runtime::Reliability::kReliable, runtime::Durability::kVolatile, 1}};
/// The finished map as a grid: for Nav2 and RViz, or from them.
inline constexpr Topic<nav_msgs::msg::OccupancyGrid> map{"map", kLatched, Accepts::kEvery};
/// People with their velocities. Each message must contain everybody nearby.
inline constexpr Topic<tandem_msgs::msg::ObstacleArray> people{
    "people", {.depth = 1}, Accepts::kEvery};
/// The shapes that the planner avoids.
inline constexpr Topic<tandem_msgs::msg::ObstacleArray> obstacles{"obstacles"};
/// The same, to be looked at.
inline constexpr Topic<visualization_msgs::msg::MarkerArray> obstacle_markers{"obstacles/markers"};

// the planner
/// A goal for the method `goal`, as RViz sends it.
inline constexpr Topic<geometry_msgs::msg::PoseStamped> goal_pose{"goal_pose", kDefault,
                                                                  Accepts::kEvery};
/// The planner's command.
inline constexpr Topic<geometry_msgs::msg::Twist> cmd_vel_shared{"cmd_vel_shared", kCommand};
/// The planned poses.
inline constexpr Topic<nav_msgs::msg::Path> plan{"plan"};
/// Where the person's own command would lead.
inline constexpr Topic<nav_msgs::msg::Path> user_path{"user_path"};
/// How planning went, in every cycle.
inline constexpr Topic<tandem_msgs::msg::PlannerStatus> planner_status{"planner/status"};

// arbitration and safety filter
/// The command of an outside autonomy, such as Nav2.
inline constexpr Topic<geometry_msgs::msg::Twist> cmd_vel_nav{"cmd_vel_nav", kCommand};
/// True presses the emergency stop.
inline constexpr Topic<std_msgs::msg::Bool> e_stop{"e_stop", kLatched};
/// The command of the source in authority.
inline constexpr Topic<geometry_msgs::msg::Twist> cmd_vel_arbitrated{"cmd_vel_arbitrated",
                                                                     kCommand};
/// Whose command is in force, and why the robot stands.
inline constexpr Topic<tandem_msgs::msg::ArbitrationStatus> arbitration_status{
    "arbitration/status"};
/// The command to the base, which the safety filter has checked.
inline constexpr Topic<geometry_msgs::msg::Twist> cmd_vel{"cmd_vel", kCommand};
/// The same with a timestamp, for bases that check its age.
inline constexpr Topic<geometry_msgs::msg::TwistStamped> cmd_vel_stamped{"cmd_vel", kCommand};
/// What the safety filter did with each command.
inline constexpr Topic<tandem_msgs::msg::FilterStatus> filter_status{"safety_filter/status"};
/// The health of every node.
inline constexpr auto diagnostics = runtime::every_node::diagnostics;

// the robot
/// The robot's odometry.
inline constexpr Topic<nav_msgs::msg::Odometry> odom{"odom", kDefault, Accepts::kEvery};
/// Transforms that change, of all publishers.
inline constexpr Topic<tf2_msgs::msg::TFMessage> tf{
    "/tf", {runtime::Reliability::kReliable, runtime::Durability::kVolatile, 100}, Accepts::kEvery};
/// Latched static transforms, one history per publisher.
inline constexpr Topic<tf2_msgs::msg::TFMessage> tf_static{
    "/tf_static",
    {runtime::Reliability::kReliable, runtime::Durability::kTransientLocal, 100},
    Accepts::kEvery};
/// The simulator's true pose and twist, in the map.
inline constexpr Topic<nav_msgs::msg::Odometry> ground_truth{"ground_truth/odom"};
/// A laser scanner's scan.
inline constexpr Topic<sensor_msgs::msg::LaserScan> scan{"scan", kSensorData};
/// A depth camera's points.
inline constexpr Topic<sensor_msgs::msg::PointCloud2> cloud_in{"cloud_in", kSensorData};
/// The simulator's contacts.
inline constexpr Topic<tandem_msgs::msg::Collision> collision{"collision"};
/// The robot's shape as URDF, for RViz.
inline constexpr Topic<std_msgs::msg::String> robot_description{"robot_description", kLatched};
/// Simulated time.
inline constexpr auto clock = runtime::every_node::clock;
/// Where to put the simulated robot.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> initial_pose{
    "initialpose", kDefault, Accepts::kEvery};
/// The robot's pose, for clients of Nav2, which publishes it under this name.
inline constexpr Topic<geometry_msgs::msg::PoseWithCovarianceStamped> amcl_pose{"amcl_pose",
                                                                                kLatched};

}  // namespace tandem::topics

namespace tandem::services {

using runtime::ServiceName;

/// Sets arbitration's policy.
inline constexpr ServiceName<tandem_msgs::srv::SetPolicy> set_policy{"~/set_policy"};
/// Releases the emergency stop, once nobody presses it.
inline constexpr ServiceName<std_srvs::srv::Trigger> release_emergency_stop{
    "~/release_emergency_stop"};
/// Puts the simulated robot back to its start.
inline constexpr ServiceName<std_srvs::srv::Trigger> reset{"~/reset"};

// what clients of Nav2 ask for
/// Whether the robot is localised, as the lifecycle state of Nav2's localiser.
inline constexpr ServiceName<lifecycle_msgs::srv::GetState> amcl_state{"amcl/get_state"};
/// Whether a goal would be accepted, as the lifecycle state of Nav2's navigator.
inline constexpr ServiceName<lifecycle_msgs::srv::GetState> navigator_state{
    "bt_navigator/get_state"};
/// Whether the robot is localised, as Nav2's lifecycle manager tells RViz's panel.
inline constexpr ServiceName<std_srvs::srv::Trigger> localization_is_active{
    "lifecycle_manager_localization/is_active"};
/// Whether a goal would be accepted, likewise.
inline constexpr ServiceName<std_srvs::srv::Trigger> navigation_is_active{
    "lifecycle_manager_navigation/is_active"};

}  // namespace tandem::services

namespace tandem::actions {

using runtime::ActionName;

/// Drives to a pose.
inline constexpr ActionName<nav2_msgs::action::NavigateToPose> navigate_to_pose{"navigate_to_pose"};
/// Drives along a path.
inline constexpr ActionName<nav2_msgs::action::FollowPath> follow_path{"follow_path"};

}  // namespace tandem::actions
