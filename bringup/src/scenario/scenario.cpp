// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/scenario.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/method.hpp"
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

// What the scenario's goal lacks for the method; empty if it has the method's form.
std::string missing_in_goal(const Scenario& scenario, GoalForm form) {
  if (form == GoalForm::kPose && !std::holds_alternative<PoseGoal>(scenario.goal))
    return "goal: {pose: [x, y, heading]}";
  if (form == GoalForm::kPoses && scenario.goals.empty())
    return "goal: {poses: [x1, y1, heading1, …]}";
  return {};
}

void check_methods(const Scenario& scenario) try {
  for (const auto& name : scenario.methods) (void)drive_method(name);
  const DriveMethod& method = drive_method(scenario.method);
  for (const auto& name : scenario.expect.except) (void)drive_method(name);
  if (const auto missing = missing_in_goal(scenario, method.goal); !missing.empty())
    throw std::invalid_argument("method `" + method.name + "` needs " + missing);
} catch (const std::invalid_argument& error) {
  throw std::invalid_argument(scenario.path + ": " + error.what());
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

std::vector<double> flat(const std::vector<Pose2>& poses) {
  std::vector<double> numbers;
  for (const Pose2& X : poses) numbers.insert(numbers.end(), {X.x, X.y, X.theta});
  return numbers;
}

// Writes what only some components read: the map's slice, its source and the fixtures.
void add_place(std::map<std::string, Values>& all, const Scenario& s) {
  for (const char* component : {"map_server", "driver", "obstacle_extractor", "safety_filter",
                                "diff_drive_sim", "octomap_builder", "shared_dwa", "hindsight"})
    all[component].insert(s.slice.begin(), s.slice.end());
  for (const char* component : {"obstacle_extractor", "safety_filter", "shared_dwa"})
    all[component]["map_source"] = {s.map_source, s.path};
  if (s.fixtures.empty()) return;
  for (const char* component :
       {"obstacle_extractor", "safety_filter", "local_planner", "shared_dwa"})
    all[component]["fixtures"] = {s.fixtures, s.path};
}

void add_people(std::map<std::string, Values>& all, const Scenario& s) {
  if (s.people.empty() && s.crossings.empty()) return;
  all["diff_drive_sim"]["people"] = {list(to_numbers(people_in(s))), s.path};
  for (const char* component : {"obstacle_extractor", "safety_filter"})
    all[component]["people"] = {"true", s.path};
}

// Component parameters implied by method, seed and place; values in the scenario take precedence.
std::map<std::string, Values> derived(const Scenario& s, const DriveOptions& options) {
  const DriveMethod& method = drive_method(s.method);
  const auto value = [&](const auto& v) { return rt::ParameterValue{text(v), s.path}; };
  std::map<std::string, Values> all;
  all["map_server"] = {{"map", value(s.map)}};
  all["driver"] = {{"driver", value(s.driver)},
                   {"seed", value(s.seed)},
                   {"steers_leader", value(steers_leader(method))}};
  all["local_planner"] = {{"method", value(method.planner_method)}};
  if (const auto* goal = std::get_if<PoseGoal>(&s.goal))
    all["local_planner"]["goal"] = value(list({goal->X_MG.x, goal->X_MG.y, goal->X_MG.theta}));
  all["hindsight"] = {{"goals", value(list(flat(s.goals)))}};
  all["arbitration"] = {{"policy", value(method.policy)}};
  all["safety_filter"] = {{"enforce", value(method.enforce && options.enforce)}};
  all["diff_drive_sim"] = {{"map", value(s.map)},
                           {"seed", value(s.seed)},
                           {"start", value(list({s.start.x, s.start.y, s.start.theta}))},
                           {"speed_factor", value(options.speed)}};
  add_place(all, s);
  add_people(all, s);
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

void hand_over_recording(const Scenario& scenario, const TeleopParams& teleop, Values& driver) {
  const Recording stick = recorded_stick(scenario.recording, teleop, scenario.recording_topic);
  driver["replay_t"] = {list(stick.t), scenario.recording};
  driver["replay_linear"] = {list(stick.linear), scenario.recording};
  driver["replay_angular"] = {list(stick.angular), scenario.recording};
}

// Gives the driver its recording and, unless the scenario sets it, the dead zone of its stick.
void hand_over_stick(const Scenario& scenario, System& system) {
  for (SystemNode& node : system.nodes) {
    if (node.component != "driver") continue;
    const auto teleop = parameters_of<TeleopNodeParams>(system, "teleop").teleop;
    Values& driver = node.options.parameters.values;
    driver.emplace("deadzone", rt::ParameterValue{text(teleop.gains.deadzone), scenario.path});
    if (!scenario.recording.empty()) hand_over_recording(scenario, teleop, driver);
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
      throw std::invalid_argument(unused + ": this name was ambiguous; " + instead);
    const std::string meant = nearest_parameter(key);
    throw std::invalid_argument(
        unused + ": unknown parameter" +
        (meant.empty() ? "; see tandem describe COMPONENT." : meant) +
        " Put parameters of other programs' nodes under the nodes' names instead of /**");
  }
}

std::vector<Walker> people_in(const Scenario& scenario) {
  auto people = scenario.people;
  for (const Crossings& crossings : scenario.crossings)
    for (auto& walker : crossing_people(crossings, scenario.seed, scenario.start.position()))
      people.push_back(std::move(walker));
  return people;
}

std::string driver_of(const Scenario& scenario) {
  return has_person(drive_method(scenario.method)) ? scenario.driver : "none";
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
  for (const auto& [component, values] : scenario.parameters)
    for (const auto& [key, value] : values) all[component][key] = value;
  if (options.lockstep) set_deterministic_budget(all["local_planner"], scenario.path);
  const DriveMethod& method = drive_method(scenario.method);
  for (const auto& component : components_of(method, scenario.map_source)) {
    rt::NodeOptions node;
    node.name = component;
    node.use_sim_time = component != "diff_drive_sim";
    node.parameters.files = {scenario.robot};
    node.parameters.values = all[component];
    if (const auto of = method.remappings.find(component); of != method.remappings.end())
      node.remappings = of->second;
    system.nodes.push_back({component, std::move(node)});
  }
  hand_over_stick(scenario, system);
  return system;
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
