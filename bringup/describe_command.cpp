// SPDX-License-Identifier: Apache-2.0
#include "bringup/describe_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <cstdio>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>

#include "arbitration/arbiter.hpp"
#include "dashboard/dashboard_node.hpp"
#include "diff_drive_sim/diff_drive_sim_node.hpp"
#include "driver/driver_node.hpp"
#include "haptics/haptics_node.hpp"
#include "hindsight/hindsight_node.hpp"
#include "joystick/joystick_node.hpp"
#include "local_planner/local_planner_node.hpp"
#include "map_server/map_server_node.hpp"
#include "obstacle_extractor/obstacle_extractor_node.hpp"
#include "octomap_builder/octomap_builder_node.hpp"
#include "safety_filter/safety_filter_node.hpp"
#include "shared_dwa/shared_dwa_node.hpp"
#include "teleop/teleop_node.hpp"

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
  void operator()(const char* name, bool value, const char* meaning) const {
    row(name, value ? "true" : "false", "", meaning);
  }
  void operator()(const char* name, const std::string& value, const char* meaning) const {
    row(name, value.empty() ? "\"\"" : value, "", meaning);
  }
};

struct Description {
  const char* topics;
  std::function<void()> print_parameters;
};

template <class Params>
Description describe(const char* topics) {
  return {topics, [] {
            Params params;
            params.visit(Printer{});
          }};
}

// The topics stand in each node's header too; here for those who have only the program.
const std::map<std::string, Description>& descriptions() {
  static const std::map<std::string, Description> all{
      {"map_server", describe<MapServerParams>("(a map file) -> octomap_binary, map")},
      {"driver", describe<DriverNodeParams>("odom, tf, leader_pose -> joy")},
      {"haptics",
       describe<HapticsParams>("cmd_vel_user, safety_filter/status -> joy/set_feedback")},
      {"joystick", describe<JoystickNodeParams>(
                       "(a joystick or gamepad) -> joy; joy/set_feedback -> (its rumble)")},
      {"teleop", describe<TeleopNodeParams>(
                     "joy, odom, tf -> cmd_vel_user, leader_pose, leader/markers, end_sim")},
      {"octomap_builder", describe<OctomapBuilderNodeParams>(
                              "scan, cloud_in, odom, tf -> octomap_local; service ~/reset")},
      {"obstacle_extractor",
       describe<ObstacleExtractorNodeParams>(
           "octomap_binary, octomap_local, odom, tf -> obstacles, obstacles/markers")},
      {"shared_dwa",
       describe<SharedDwaNodeParams>("cmd_vel_user, octomap_binary, octomap_local, odom, "
                                     "tf -> cmd_vel_shared, planner/status")},
      {"hindsight",
       describe<HindsightNodeParams>("cmd_vel_user, octomap_binary, odom, tf -> cmd_vel_assisted, "
                                     "hindsight/markers")},
      {"local_planner",
       describe<LocalPlannerNodeParams>(
           "odom, tf, obstacles, cmd_vel, leader_pose | cmd_vel_user | goal_pose -> "
           "cmd_vel_shared, plan, user_path, planner/status")},
      {"arbitration",
       describe<ArbiterParams>("cmd_vel_user, cmd_vel_shared, cmd_vel_nav, planner/status, "
                               "safety_filter/status, e_stop -> cmd_vel_arbitrated, "
                               "arbitration/status, /diagnostics; services ~/set_policy, "
                               "~/release_emergency_stop")},
      {"safety_filter", describe<SafetyFilterNodeParams>(
                            "cmd_vel_arbitrated, octomap_binary, octomap_local, odom, tf "
                            "-> cmd_vel, safety_filter/status, /diagnostics")},
      {"dashboard", describe<DashboardParams>(
                        "every topic and service -> web clients; web clients -> joy, cmd_vel_user, "
                        "goal_pose, initialpose, end_sim, e_stop; own service ~/take_wheel")},
      {"diff_drive_sim",
       describe<DiffDriveSimNodeParams>("cmd_vel, initialpose -> odom, tf, ground_truth/odom, "
                                        "scan, collision, /clock; service ~/reset")}};
  return all;
}

void print(const std::string& component) {
  const auto it = descriptions().find(component);
  if (it == descriptions().end()) {
    std::string known;
    for (const auto& entry : descriptions()) known += " " + entry.first;
    throw std::invalid_argument("no component '" + component + "'; there are:" + known);
  }
  std::printf("%s: %s\n\n", component.c_str(), it->second.topics);
  std::printf("  %-24s %-12s %-22s %s\n", "parameter", "default", "bounds", "meaning");
  it->second.print_parameters();
}

}  // namespace

void add_describe_command(CLI::App& app) {
  auto* command = app.add_subcommand("describe", "Topics and parameters of a component");
  auto component = std::make_shared<std::string>();
  command->add_option("component", *component, "its name; see `tandem list`")->required();
  command->callback([component] { print(*component); });
}

}  // namespace tandem
