// SPDX-License-Identifier: Apache-2.0
#include "bringup/describe_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>

#include "bringup/component_params.hpp"

namespace tandem {
namespace {

// A visitor of parameter structs that prints each field as a row.
struct Printer {
  static void row(const char* name, const std::string& value, const std::string& bounds,
                  const char* meaning) {
    std::printf("  %-24s %-12s %-22s %s\n", name, value.c_str(), bounds.c_str(), meaning);
  }
  static std::string bounds(const Range& range) {
    return fmt::format("[{}, {}]", range.min, range.max);
  }

  void operator()(const char* name, double value, const Range& range, const char* meaning) const {
    row(name, fmt::format("{}", value), bounds(range), meaning);
  }
  void operator()(const char* name, int value, const Range& range, const char* meaning) const {
    row(name, fmt::format("{}", value), bounds(range), meaning);
  }
  void operator()(const char* name, const std::string& value, const OneOf& choices,
                  const char* meaning) const {
    row(name, value, fmt::format("{}", fmt::join(choices.names, " | ")), meaning);
  }
  void operator()(const char* name, const std::vector<double>& values, const Range& range,
                  const char* meaning) const {
    row(name, fmt::format("[{}]", fmt::join(values, ", ")), bounds(range), meaning);
  }
  void operator()(const char* name, const std::vector<std::string>& values, const OneOf& choices,
                  const char* meaning) const {
    row(name, fmt::format("[{}]", fmt::join(values, ", ")),
        fmt::format("each {}", fmt::join(choices.names, " | ")), meaning);
  }
  void operator()(const char* name, bool value, const char* meaning) const {
    row(name, value ? "true" : "false", "", meaning);
  }
  void operator()(const char* name, const std::string& value, const char* meaning) const {
    row(name, value.empty() ? "\"\"" : value, "", meaning);
  }
};

// The topics stand in each node's header too; here for those who have only the program.
const std::map<std::string, const char*>& topics_of_components() {
  static const std::map<std::string, const char*> all{
      {"map_server", "(a map file) -> octomap_binary, map"},
      {"driver", "odom, tf, leader_pose, teleop/status -> joy"},
      {"haptics", "cmd_vel_user, safety_filter/status -> joy/set_feedback"},
      {"joystick", "(a joystick or gamepad) -> joy; joy/set_feedback -> (its rumble)"},
      {"teleop",
       "joy, cmd_vel_user, odom, tf, planner/status -> cmd_vel_user, leader_pose, leader/markers, "
       "teleop/status, end_sim"},
      {"octomap_builder",
       "scan, cloud_in, odom, tf -> octomap_local, sensing_status, /diagnostics; service ~/reset"},
      {"obstacle_extractor",
       "octomap_binary, octomap_local, odom, tf -> obstacles, obstacles/markers"},
      {"shared_dwa",
       "cmd_vel_user, octomap_binary, octomap_local, odom, "
       "tf -> cmd_vel_shared, planner/status"},
      {"hindsight",
       "cmd_vel_user, octomap_binary, odom, tf -> cmd_vel_assisted, "
       "hindsight/markers"},
      {"local_planner",
       "odom, tf, obstacles, cmd_vel, leader_pose | cmd_vel_user | goal_pose -> "
       "cmd_vel_shared, plan, user_path, planner/status"},
      {"arbitration",
       "cmd_vel_user, cmd_vel_shared, cmd_vel_nav, teleop/status, planner/status, "
       "safety_filter/status, e_stop -> cmd_vel_arbitrated, "
       "arbitration/status, /diagnostics; services ~/set_policy, "
       "~/release_emergency_stop"},
      {"safety_filter",
       "cmd_vel_arbitrated, octomap_binary, octomap_local, sensing_status, odom, tf "
       "-> cmd_vel, safety_filter/status, /diagnostics"},
      {"dashboard",
       "every topic and service -> web clients; web clients -> joy, cmd_vel_user, "
       "goal_pose, initialpose, end_sim, e_stop; own service ~/take_wheel"},
      {"diff_drive_sim",
       "cmd_vel, initialpose -> odom, tf, ground_truth/odom, "
       "scan, collision, /clock; service ~/reset"}};
  return all;
}

void print(const std::string& component) {
  std::string known;
  bool found = false;
  for_each_component([&](const char* name, auto params) {
    known += std::string{" "} + name;
    if (component != name) return;
    found = true;
    std::printf("%s: %s\n\n", name, topics_of_components().at(name));
    std::printf("  %-24s %-12s %-22s %s\n", "parameter", "default", "bounds", "meaning");
    params.visit(Printer{});
  });
  if (!found) throw std::invalid_argument("no component '" + component + "'; there are:" + known);
}

}  // namespace

void add_describe_command(CLI::App& app) {
  auto* command = app.add_subcommand("describe", "Topics and parameters of a component");
  auto component = std::make_shared<std::string>();
  command->add_option("component", *component, "its name; see `tandem list`")->required();
  command->callback([component] { print(*component); });
}

}  // namespace tandem
