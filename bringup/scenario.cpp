// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <sstream>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

#include "bringup/world.hpp"
#include "runtime/yaml_text.hpp"

namespace tandem {
namespace {

using Values = std::map<std::string, rt::ParameterValue>;

constexpr double kLongest = 1e6;               // [s] of a drive
constexpr unsigned kLargestSeed = 2147483647;  // what a parameter may hold

[[noreturn]] void fail(const std::string& path, const YAML::Node& at, const std::string& what) {
  const std::string line = at.Mark().is_null() ? "" : ":" + std::to_string(at.Mark().line + 1);
  throw std::invalid_argument(path + line + ": " + what);
}

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

constexpr const char* kind(bool) { return "true or false"; }
constexpr const char* kind(double) { return "a finite number"; }
constexpr const char* kind(int) { return "an integer"; }
constexpr const char* kind(unsigned) { return "an integer of 0 or more"; }
const char* kind(const std::string&) { return "text"; }
const char* kind(const std::vector<double>&) { return "a list of finite numbers"; }
const char* kind(const std::vector<std::string>&) { return "a list of words"; }

bool is_sound(double value) { return std::isfinite(value); }
bool is_sound(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}
template <class T>
bool is_sound(const T&) {
  return true;
}

// The keys of a YAML map, each once.
std::vector<std::string> keys_of(const YAML::Node& map, const std::string& path) {
  if (!map.IsMap()) fail(path, map, "expected `key: value` lines");
  std::vector<std::string> keys;
  std::set<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) fail(path, entry.first, "a key must be a word");
    keys.push_back(entry.first.Scalar());
    if (!seen.insert(keys.back()).second)
      fail(path, entry.first, "`" + keys.back() + "` is given twice");
  }
  return keys;
}

// Reads one YAML map key by key and complains, with file and line, of what it does not know.
class Section {
 public:
  Section(const YAML::Node& node, std::string path)
      : node_{node}, path_{std::move(path)}, given_{keys_of(node_, path_)} {}

  template <class T>
  T required(const char* key) {
    require(key);
    return as<T>(node_[key], key);
  }
  template <class T>
  T optional(const char* key, T value) {
    known_.emplace_back(key);
    return node_[key] ? as<T>(node_[key], key) : value;
  }
  YAML::Node required_child(const char* key) {
    require(key);
    return node_[key];
  }
  YAML::Node child(const char* key) {
    known_.emplace_back(key);
    return node_[key];
  }
  void finish() const {
    for (const auto& key : given_)
      if (std::find(known_.begin(), known_.end(), key) == known_.end())
        fail(key, "unknown key `" + key + "`; known here: " + joined(known_));
  }
  // Complains of the value of a key that is given.
  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    tandem::fail(path_, node_[key], what);
  }

 private:
  void require(const char* key) {
    known_.emplace_back(key);
    if (!node_[key]) tandem::fail(path_, node_, std::string("`") + key + "` is missing");
  }
  template <class T>
  T as(const YAML::Node& node, const char* key) const {
    try {
      const T value = node.as<T>();
      if (is_sound(value)) return value;
    } catch (const YAML::Exception&) {  // said below
    }
    tandem::fail(path_, node,
                 std::string("`") + key + "` = " + rt::yaml_text(node) + " is not " + kind(T{}));
  }

  YAML::Node node_;
  std::string path_;
  std::vector<std::string> given_, known_;
};

std::string beside(const std::string& file, const std::string& relative) {
  const std::filesystem::path path{relative};
  if (path.is_absolute()) return relative;
  return (std::filesystem::path(file).parent_path() / path).lexically_normal().string();
}

Pose2 pose(const std::vector<double>& v, const std::string& where) {
  if (v.size() != 3) throw std::invalid_argument(where + " needs three numbers: x, y, heading");
  return {v[0], v[1], v[2]};
}

Goal read_goal(const YAML::Node& node, const std::string& path) {
  Section goal{node, path};
  const auto region = goal.optional<std::vector<double>>("region", {});
  const auto at = goal.optional<std::vector<double>>("pose", {});
  const double tolerance = goal.optional("tolerance", 0.2);
  const double time = goal.optional("roam_time", 0.0);
  const double distance = goal.optional("roam_distance", 0.0);
  goal.finish();
  if ((region.empty() ? 0 : 1) + (at.empty() ? 0 : 1) + (time > 0.0 ? 1 : 0) != 1)
    fail(path, node,
         "goal needs one of region: [x1, y1, x2, y2], pose: [x, y, heading], roam_time");
  if (!at.empty()) {
    if (!(tolerance > 0.0)) goal.fail("tolerance", "`tolerance` must be above 0");
    return PoseGoal{pose(at, path + ": goal.pose"), tolerance};
  }
  if (region.empty()) return RoamGoal{time, distance};
  if (region.size() != 4 || region[0] >= region[2] || region[1] >= region[3])
    goal.fail("region", "region needs [x1, y1, x2, y2] with x1 < x2 and y1 < y2");
  return RegionGoal{{region[0], region[1]}, {region[2], region[3]}};
}

Expectation read_expectation(const YAML::Node& node, const std::string& path) {
  Expectation expect;
  if (!node) return expect;
  Section section{node, path};
  expect.reached = section.optional("reached", expect.reached);
  expect.max_collisions = section.optional("max_collisions", expect.max_collisions);
  expect.max_fallback_share = section.optional("max_fallback_share", expect.max_fallback_share);
  expect.max_final_position_error =
      section.optional("max_final_position_error", expect.max_final_position_error);
  expect.except = section.optional("except", expect.except);
  section.finish();
  return expect;
}

Values read_values(const YAML::Node& node, const std::string& path) {
  Values values;
  if (!node || node.IsNull()) return values;
  for (const auto& key : keys_of(node, path))
    values[key] = {rt::yaml_text(node[key]),
                   path + ":" + std::to_string(node[key].Mark().line + 1)};
  return values;
}

std::map<std::string, Values> read_parameters(const YAML::Node& node, const std::string& path) {
  static const std::vector<std::string> components{
      "map_server",    "driver",      "teleop",        "obstacle_extractor",
      "local_planner", "arbitration", "safety_filter", "diff_drive_sim"};
  std::map<std::string, Values> all;
  if (!node || node.IsNull()) return all;
  for (const auto& name : keys_of(node, path)) {
    if (std::find(components.begin(), components.end(), name) == components.end())
      fail(path, node[name],
           "parameters for `" + name + "`, which is none of " + joined(components));
    all[name] = read_values(node[name], path);
  }
  return all;
}

void check_methods(const Scenario& scenario) {
  auto names = scenario.methods;
  names.push_back(scenario.method);
  names.insert(names.end(), scenario.expect.except.begin(), scenario.expect.except.end());
  for (const auto& name : names)
    if (std::find(all_methods().begin(), all_methods().end(), name) == all_methods().end())
      throw std::invalid_argument(scenario.path + ": method `" + name + "` is none of " +
                                  joined(all_methods()));
  if (scenario.method == "goal" && !std::holds_alternative<PoseGoal>(scenario.goal))
    throw std::invalid_argument(scenario.path +
                                ": method `goal` needs goal: {pose: [x, y, heading]}");
}

template <class T>
std::string text(const T& value) {
  std::ostringstream out;
  out << std::boolalpha << value;
  return out.str();
}

std::string list(std::initializer_list<double> values) {
  std::string out = "[";
  for (const double value : values) out += (out.size() > 1 ? ", " : "") + text(value);
  return out + "]";
}

bool plans(const std::string& method) { return method != "manual" && method != "safety_filter"; }

// What the method, the seed and the place mean for each component; the scenario's own values win.
std::map<std::string, Values> derived(const Scenario& s, const DriveOptions& options) {
  const bool enforce = s.method != "manual" && options.enforce;
  const std::string policy = s.method == "goal"    ? "autonomous"
                             : s.method == "blend" ? "blend"
                             : plans(s.method)     ? "shared"
                                                   : "manual";
  const auto value = [&](const auto& v) { return rt::ParameterValue{text(v), s.path}; };
  std::map<std::string, Values> all;
  all["map_server"] = {{"map", value(s.map)}};
  all["obstacle_extractor"] = {};
  all["teleop"] = {};
  all["driver"] = {{"seed", value(s.seed)},
                   {"steers_leader", value(s.method == "leader" || s.method == "path")}};
  all["local_planner"] = {{"method", value(s.method == "blend" ? "intention" : s.method)}};
  if (const auto* goal = std::get_if<PoseGoal>(&s.goal))
    all["local_planner"]["goal"] = value(list({goal->X_MG.x, goal->X_MG.y, goal->X_MG.theta}));
  all["arbitration"] = {{"policy", value(policy)}};
  all["safety_filter"] = {{"enforce", value(enforce)}};
  all["diff_drive_sim"] = {{"map", value(s.map)},
                           {"seed", value(s.seed)},
                           {"start", value(list({s.start.x, s.start.y, s.start.theta}))},
                           {"speed_factor", value(options.speed)}};
  for (const char* component :
       {"map_server", "obstacle_extractor", "safety_filter", "diff_drive_sim"})
    all[component].insert(s.slice.begin(), s.slice.end());
  if (!s.fixtures.empty())
    for (const char* component : {"obstacle_extractor", "safety_filter", "local_planner"})
      all[component]["fixtures"] = value(s.fixtures);
  if (!plans(s.method)) all.erase("local_planner");
  if (s.method == "goal") all.erase("driver"), all.erase("teleop");
  return all;
}

// No wall clock in lockstep: iterations are counted instead, about as many as fit into the 35 ms.
void set_deterministic_budget(Values& planner, const std::string& path) {
  planner["time_budget"] = {"0.0", path};
  planner.emplace("iteration_budget", rt::ParameterValue{"30", path});
}

}  // namespace

const std::vector<std::string>& all_methods() {
  static const std::vector<std::string> methods{"manual", "safety_filter", "leader", "intention",
                                                "path",   "blend",         "goal"};
  return methods;
}

Scenario load_scenario(const std::string& path) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::BadFile&) {
    throw std::invalid_argument(path + ": no such scenario file");
  } catch (const YAML::ParserException& error) {
    throw std::invalid_argument(path + ":" + std::to_string(error.mark.line + 1) + ": " +
                                error.msg);
  }
  Section file{root, path};
  Scenario s;
  s.path = path;
  s.name = file.required<std::string>("scenario");
  (void)file.optional<std::string>("about", "");
  s.map = file.required<std::string>("map");
  if (s.map != "clutter") s.map = beside(path, s.map);
  s.robot = beside(path, file.required<std::string>("robot"));
  if (const auto fixtures = file.optional<std::string>("fixtures", ""); !fixtures.empty())
    s.fixtures = beside(path, fixtures);
  s.start = pose(file.required<std::vector<double>>("start"), path + ": start");
  s.goal = read_goal(file.required_child("goal"), path);
  s.method = file.required<std::string>("method");
  s.methods = file.optional<std::vector<std::string>>("methods", {s.method});
  s.duration = file.optional("duration", s.duration);
  s.seed = file.optional("seed", s.seed);
  s.slice = read_values(file.child("slice"), path);
  s.parameters = read_parameters(file.child("parameters"), path);
  s.expect = read_expectation(file.child("expect"), path);
  file.finish();
  if (!(s.duration > 0.0 && s.duration <= kLongest))
    file.fail("duration", "`duration` = " + text(s.duration) + " outside (0, " + text(kLongest) +
                              "]: [s] simulated, then the drive is over");
  check_methods(s);
  return s;
}

Scenario with_options(Scenario scenario, const DriveOptions& options) {
  if (!options.method.empty()) scenario.method = options.method;
  if (options.seed != 0) scenario.seed = options.seed;
  if (!options.map.empty()) scenario.map = options.map;
  if (scenario.seed > kLargestSeed)
    throw std::invalid_argument(scenario.path + ": seed " + text(scenario.seed) +
                                " is above the largest, " + text(kLargestSeed));
  check_methods(scenario);
  return is_family(scenario.map) ? in_its_world(std::move(scenario)) : scenario;
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
    system.nodes.push_back({component, std::move(node)});
  }
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
    failed.push_back(text(100.0 * share) + " % of the plans were fallbacks");
  if (result.final_position_error_m > expect.max_final_position_error)
    failed.push_back("final position error " + text(result.final_position_error_m) + " m");
  return failed;
}

}  // namespace tandem
