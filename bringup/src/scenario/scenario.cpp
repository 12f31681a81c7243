// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/scenario.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/replay.hpp"
#include "bringup/scenario/seeded_world.hpp"
#include "bringup/system/parameter_names.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/driver/driver.hpp"
#include "tandem/teleop/teleop_node.hpp"

namespace tandem {
namespace {

using Values = std::map<std::string, rt::ParameterValue>;

constexpr unsigned kLargestSeed = 2147483647;  // largest value of a parameter

template <class T>
std::string text(const T& value) {
  return fmt::format("{}", value);
}

void check_methods(const Scenario& scenario) {
  auto names = scenario.methods;
  names.push_back(scenario.method);
  names.insert(names.end(), scenario.expect.except.begin(), scenario.expect.except.end());
  for (const auto& name : names)
    if (std::find(all_methods().begin(), all_methods().end(), name) == all_methods().end())
      throw std::invalid_argument(scenario.path + ": method `" + name + "` is none of " +
                                  fmt::format("{}", fmt::join(all_methods(), ", ")));
  if (scenario.method == "goal" && !std::holds_alternative<PoseGoal>(scenario.goal))
    throw std::invalid_argument(scenario.path +
                                ": method `goal` needs goal: {pose: [x, y, heading]}");
  if (scenario.method == "hindsight" && scenario.goals.empty())
    throw std::invalid_argument(scenario.path +
                                ": method `hindsight` needs goal: {poses: [x1, y1, heading1, …]}");
}

bool is_replayed(const Scenario& scenario) {
  return DriverName{scenario.driver}.driver == "replay";
}

void check_driver(const Scenario& scenario) {
  try {
    (void)DriverName{scenario.driver};
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(scenario.path + ": " + error.what());
  }
  if (is_replayed(scenario) == scenario.recording.empty())
    throw std::invalid_argument(scenario.path + ": " +
                                (scenario.recording.empty()
                                     ? "driver `replay` needs a `recording` (or --recording FOLDER)"
                                     : "a `recording` needs `driver: replay`"));
  if (!scenario.recording_topic.empty() && scenario.recording.empty())
    throw std::invalid_argument(scenario.path + ": a `recording_topic` needs a `recording`");
}

std::string list(const std::vector<double>& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

// The planner method that a scenario method uses.
std::string planner_method(const std::string& method) {
  const bool obeys = method == "blend" || method == "adaptive" || method == "hindsight";
  return obeys ? "intention" : method;
}

std::vector<double> flat(const std::vector<Pose2>& poses) {
  std::vector<double> numbers;
  for (const Pose2& X : poses) numbers.insert(numbers.end(), {X.x, X.y, X.theta});
  return numbers;
}

bool plans(const std::string& method) { return method != "manual" && method != "safety_filter"; }

// Component parameters implied by method, seed and place; values in the scenario take precedence.
std::map<std::string, Values> derived(const Scenario& s, const DriveOptions& options) {
  const bool enforce = s.method != "manual" && options.enforce;
  const std::string policy = s.method == "goal"                              ? "autonomous"
                             : s.method == "blend" || s.method == "adaptive" ? s.method
                             : plans(s.method)                               ? "shared"
                                                                             : "manual";
  const auto value = [&](const auto& v) { return rt::ParameterValue{text(v), s.path}; };
  std::map<std::string, Values> all;
  all["map_server"] = {{"map", value(s.map)}};
  all["obstacle_extractor"] = {};
  all["teleop"] = {};
  all["driver"] = {{"driver", value(s.driver)},
                   {"seed", value(s.seed)},
                   {"steers_leader", value(s.method == "leader" || s.method == "path")}};
  all["local_planner"] = {{"method", value(planner_method(s.method))}};
  if (const auto* goal = std::get_if<PoseGoal>(&s.goal))
    all["local_planner"]["goal"] = value(list({goal->X_MG.x, goal->X_MG.y, goal->X_MG.theta}));
  all["arbitration"] = {{"policy", value(policy)}};
  all["safety_filter"] = {{"enforce", value(enforce)}};
  all["diff_drive_sim"] = {{"map", value(s.map)},
                           {"seed", value(s.seed)},
                           {"start", value(list({s.start.x, s.start.y, s.start.theta}))},
                           {"speed_factor", value(options.speed)}};
  for (const char* component :
       {"map_server", "driver", "obstacle_extractor", "safety_filter", "diff_drive_sim"})
    all[component].insert(s.slice.begin(), s.slice.end());
  if (!s.fixtures.empty())
    for (const char* component : {"obstacle_extractor", "safety_filter", "local_planner"})
      all[component]["fixtures"] = value(s.fixtures);
  for (const char* component : {"obstacle_extractor", "safety_filter"})
    all[component]["map_source"] = value(s.map_source);
  Values map_reader = s.slice;
  map_reader["map_source"] = value(s.map_source);
  if (!s.fixtures.empty()) map_reader["fixtures"] = value(s.fixtures);
  if (s.map_source != "static") all["octomap_builder"] = s.slice;
  if (s.method == "dwa") all["shared_dwa"] = map_reader;
  if (s.method == "hindsight") {
    all["hindsight"] = s.slice;
    all["hindsight"]["goals"] = value(list(flat(s.goals)));
  }
  if (!plans(s.method) || s.method == "dwa") all.erase("local_planner");
  if (!s.people.empty() || !s.crossings.empty()) {
    all["diff_drive_sim"]["people"] = value(list(to_numbers(people_in(s))));
    for (const char* component : {"obstacle_extractor", "safety_filter"})
      all[component]["people"] = value(true);
  }
  if (s.method == "goal") all.erase("driver"), all.erase("teleop");
  return all;
}

// Lockstep has no wall-clock budget: iterations are limited instead, to about as many as fit into
// 35 ms.
void set_deterministic_budget(Values& planner, const std::string& path) {
  planner["time_budget"] = {"0.0", path};
  planner.emplace("iteration_budget", rt::ParameterValue{"30", path});
}

// The scenario's topic does not apply to another recording; another driver has no recording.
void choose_recording(Scenario& scenario, const DriveOptions& options) {
  const bool another = !options.driver.empty() && options.recording.empty() &&
                       DriverName{options.driver}.driver != "replay";
  if (another || !options.recording.empty()) {
    scenario.recording = options.recording;
    scenario.recording_topic.clear();
  }
  if (!options.recording_topic.empty()) scenario.recording_topic = options.recording_topic;
}

// Writes the recorded joystick input into the driver's parameters.
void hand_over_recording(const Scenario& scenario, System& system) {
  const auto teleop = parameters_of<TeleopNodeParams>(system, "teleop").teleop;
  for (SystemNode& node : system.nodes) {
    if (node.component != "driver") continue;
    const Recording stick = recorded_stick(scenario.recording, teleop, scenario.recording_topic);
    auto& values = node.options.parameters.values;
    values["replay_t"] = {list(stick.t), scenario.recording};
    values["replay_linear"] = {list(stick.linear), scenario.recording};
    values["replay_angular"] = {list(stick.angular), scenario.recording};
  }
}

Eigen::Vector2d edge_of(const Footprint& footprint, const std::string& edge) {
  const Extent e = extent(footprint);
  if (edge == "front") return {e.front, 0.0};
  if (edge == "rear") return {-e.rear, 0.0};
  return {0.0, edge == "left" ? e.left : -e.right};
}

// Converts a goal pose of a robot edge to one of base_link; goal regions still refer to the edge.
Scenario with_goal_of_edge(Scenario scenario, const DriveOptions& options) {
  const std::string edge = std::exchange(scenario.goal_edge, "");
  if (edge.empty()) return scenario;
  const System system = system_of(scenario, options);
  const auto robot = parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim").robot;
  scenario.p_BA = edge_of(footprint_of(robot), edge);
  if (auto* goal = std::get_if<PoseGoal>(&scenario.goal))
    goal->X_MG = compose(goal->X_MG, {-scenario.p_BA.x(), -scenario.p_BA.y(), 0.0});
  return scenario;
}

}  // namespace

void check_scenario(const Scenario& scenario) {
  check_methods(scenario);
  check_driver(scenario);
}

void check_robot(const Scenario& scenario) {
  const rt::ParameterStore reads{"/diff_drive_sim", {.files = {scenario.robot}}};
  for (const auto& unused : rt::unused_wildcard_keys()) {  // "file:line: key"
    if (!unused.starts_with(scenario.robot + ":")) continue;
    const std::string key = unused.substr(unused.find(": ", scenario.robot.size()) + 2);
    if (is_parameter(key)) continue;
    if (const char* instead = instead_of(key))
      throw std::invalid_argument(unused + ": this name meant several things; " + instead);
    const std::string meant = nearest_parameter(key);
    throw std::invalid_argument(
        unused + " is no parameter of any component" +
        (meant.empty() ? "; tandem describe COMPONENT lists them." : meant) +
        " What is for nodes of others belongs under their names instead of /**");
  }
}

const std::vector<std::string>& all_methods() {
  static const std::vector<std::string> methods{
      "manual", "safety_filter", "leader", "intention", "path",
      "blend",  "adaptive",      "dwa",    "hindsight", "goal"};
  return methods;
}

std::vector<Walker> people_in(const Scenario& scenario) {
  auto people = scenario.people;
  for (const Crossings& crossings : scenario.crossings)
    for (auto& walker : crossing_people(crossings, scenario.seed, scenario.start.position()))
      people.push_back(std::move(walker));
  return people;
}

std::string driver_of(const Scenario& scenario) {
  return scenario.method == "goal" ? "none" : scenario.driver;
}

Scenario with_options(Scenario scenario, const DriveOptions& options) {
  if (!options.method.empty()) scenario.method = options.method;
  if (!options.driver.empty()) scenario.driver = options.driver;
  choose_recording(scenario, options);
  if (options.seed != 0) scenario.seed = options.seed;
  if (!options.map.empty()) scenario.map = options.map;
  if (scenario.seed > kLargestSeed)
    throw std::invalid_argument(scenario.path + ": seed " + text(scenario.seed) +
                                " is above the largest, " + text(kLargestSeed));
  check_scenario(scenario);
  if (is_family(scenario.map)) return in_its_world(std::move(scenario));
  if (!scenario.goals.empty()) scenario = with_its_goal(std::move(scenario));
  return with_goal_of_edge(std::move(scenario), options);
}

System system_of(const Scenario& scenario, const DriveOptions& options) {
  System system;
  system.path = scenario.path;
  auto all = derived(scenario, options);
  for (const auto& [component, values] : scenario.parameters) {
    for (const auto& [key, value] : values)
      if (const auto it = all.find(component); it != all.end()) it->second[key] = value;
  }
  if (const auto it = all.find("local_planner"); options.lockstep && it != all.end())
    set_deterministic_budget(it->second, scenario.path);
  for (const auto& [component, values] : all) {
    rt::NodeOptions node;
    node.name = component;
    node.use_sim_time = component != "diff_drive_sim";
    node.parameters.files = {scenario.robot};
    node.parameters.values = values;
    if (component == "local_planner" && scenario.method == "hindsight")
      node.remappings = {{"cmd_vel_user", "cmd_vel_assisted"}};
    system.nodes.push_back({component, std::move(node)});
  }
  if (!scenario.recording.empty()) hand_over_recording(scenario, system);
  return system;
}

std::vector<std::string> drive_components() {
  std::set<std::string> names;
  Scenario any;
  any.map_source = "both";
  for (const auto& method : all_methods()) {
    any.method = method;
    for (const auto& [component, values] : derived(any, {})) names.insert(component);
  }
  return {names.begin(), names.end()};
}

std::vector<std::string> failures(const Scenario& scenario, const DriveResult& result) {
  const Expectation& expect = scenario.expect;
  if (std::find(expect.except.begin(), expect.except.end(), result.method) != expect.except.end())
    return {};
  std::vector<std::string> failed;
  if (expect.reached && !result.reached) failed.emplace_back("the goal was not reached");
  if (result.collisions > expect.max_collisions)
    failed.push_back(text(result.collisions) + " collisions, allowed " +
                     text(expect.max_collisions));
  const double share = result.counts.plans == 0
                           ? 0.0
                           : static_cast<double>(result.counts.plan_fallbacks) /
                                 static_cast<double>(result.counts.plans);
  if (share > expect.max_fallback_share)
    failed.push_back(fmt::format("{:.2f} % of the plans were fallbacks", 100.0 * share));
  if (result.final_position_error_m > expect.max_final_position_error)
    failed.push_back(fmt::format("final position error {:.3f} m", result.final_position_error_m));
  return failed;
}

}  // namespace tandem
