// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/component_topics.hpp"

#include <initializer_list>
#include <map>
#include <stdexcept>

#include "tandem/io/topics.hpp"

namespace tandem {
namespace {

using Names = std::vector<const char*>;

Names joined(std::initializer_list<Names> parts) {
  Names all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const std::map<std::string, ComponentTopics>& all_components() {
  using namespace topics;
  static const Names pose{odom.name, tf.name, tf_static.name};                 // RobotStateInput
  static const Names maps{octomap_binary.name, map.name, octomap_local.name};  // MapInput
  static const std::map<std::string, ComponentTopics> all{
      {"map_server",
       {.subscribes = {},
        .publishes = {octomap_binary.name, map.name},
        .other_input = "(a map file)"}},
      {"driver",
       {.subscribes = joined({pose, maps, {leader_pose.name, teleop_status.name}}),
        .publishes = {joy.name}}},
      {"haptics",
       {.subscribes = {cmd_vel_user.name, filter_status.name}, .publishes = {joy_feedback.name}}},
      {"joystick",
       {.subscribes = {joy_feedback.name},
        .publishes = {joy.name},
        .other_input = "(a joystick or gamepad)",
        .other_output = "(its rumble)"}},
      {"teleop",
       {.subscribes = joined({{joy.name, cmd_vel_user.name, planner_status.name}, pose}),
        .publishes = {cmd_vel_user.name, leader_pose.name, leader_markers.name, teleop_status.name,
                      end_sim.name, diagnostics.name}}},
      {"octomap_builder",
       {.subscribes = joined({{scan.name, cloud_in.name}, pose}),
        .publishes = {octomap_local.name, sensing_status.name, diagnostics.name},
        .serves = {services::reset.name}}},
      {"obstacle_extractor",
       {.subscribes = joined({maps, pose, {people.name}}),
        .publishes = {obstacles.name, obstacle_markers.name, diagnostics.name}}},
      {"shared_dwa",
       {.subscribes = joined({{cmd_vel_user.name}, maps, pose}),
        .publishes = {cmd_vel_shared.name, planner_status.name, diagnostics.name}}},
      {"hindsight",
       {.subscribes = joined({{cmd_vel_user.name}, maps, pose}),
        .publishes = {cmd_vel_assisted.name, hindsight_markers.name}}},
      {"local_planner",
       {.subscribes = joined({pose,
                              {obstacles.name, cmd_vel.name, leader_pose.name, cmd_vel_user.name,
                               goal_pose.name, filter_status.name}}),
        .publishes = {cmd_vel_shared.name, plan.name, user_path.name, planner_status.name,
                      diagnostics.name}}},
      {"arbitration",
       {.subscribes = {cmd_vel_user.name, cmd_vel_shared.name, cmd_vel_nav.name, teleop_status.name,
                       planner_status.name, filter_status.name, e_stop.name, diagnostics.name},
        .publishes = {cmd_vel_arbitrated.name, arbitration_status.name, diagnostics.name},
        .serves = {services::set_policy.name, services::release_emergency_stop.name}}},
      {"safety_filter",
       {.subscribes =
            joined({{cmd_vel_arbitrated.name}, maps, pose, {sensing_status.name, people.name}}),
        .publishes = {cmd_vel.name, filter_status.name, diagnostics.name}}},
      {"dashboard",
       {.subscribes = {"*"},
        .publishes = {joy.name, cmd_vel_user.name, goal_pose.name, initial_pose.name, end_sim.name,
                      e_stop.name},
        .calls = {"*"},
        .other_input = "(web clients)",
        .other_output = "(web clients; their service ~/take_wheel)"}},
      {"diff_drive_sim",
       {.subscribes = {cmd_vel.name, initial_pose.name},
        .publishes = {clock.name, odom.name, ground_truth.name, tf.name, tf_static.name, scan.name,
                      collision.name, people.name},
        .serves = {services::reset.name}}}};
  return all;
}

}  // namespace

const ComponentTopics& topics_of(const std::string& component) {
  const auto found = all_components().find(component);
  if (found == all_components().end())
    throw std::invalid_argument("no component of ours is called '" + component + "'");
  return found->second;
}

const ComponentTopics& topics_of_any_node() {
  static const ComponentTopics any{
      .subscribes = {topics::clock.name},
      .publishes = {"/rosout", "/parameter_events", topics::diagnostics.name},
      .serves = {"~/describe_parameters", "~/get_parameter_types", "~/get_parameters",
                 "~/list_parameters", "~/set_parameters", "~/set_parameters_atomically",
                 "~/get_logger_levels", "~/set_logger_levels", "~/get_type_description"}};
  return any;
}

}  // namespace tandem
