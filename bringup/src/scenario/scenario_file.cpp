// SPDX-License-Identifier: Apache-2.0
// Parses a scenario's YAML; errors name file, line and key.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>
#include <yaml-cpp/yaml.h>

#include "bringup/scenario/scenario.hpp"
#include "tandem/config/yaml_document.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

using Values = std::map<std::string, rt::ParameterValue>;

constexpr double kLongest = 1e6;  // [s] of a drive
constexpr int kMostPeople = 100;
constexpr double kMostOfAPerson = 5.0;  // [m/s, m] speed or radius
constexpr double kThinnest = 0.05;      // [m] radius

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

// Reads one YAML map key by key; unknown keys are errors that name file and line.
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
  // Throws an error about the value of a key that is present.
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
    } catch (const YAML::Exception&) {  // reported below
    }
    tandem::fail(path_, node,
                 std::string("`") + key + "` = " + yaml_text(node) + " is not " + kind(T{}));
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

// The name becomes the file name of pictures and tables, so it must not contain a slash.
std::string read_name(Section& section) {
  const auto name = section.required<std::string>("scenario");
  if (name.empty() || name.find('/') != std::string::npos)
    section.fail("scenario", "`scenario` = " + name + ": a name needs a letter, and no `/`");
  return name;
}

std::vector<Pose2> read_poses(Section& section, const char* key) {
  const auto numbers = section.optional<std::vector<double>>(key, {});
  if (numbers.size() % 3 != 0)
    section.fail(key, std::string("`") + key + "` needs x1, y1, heading1, x2, … [m, rad]");
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    poses.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return poses;
}

std::optional<RegionGoal> read_region(Section& section, const char* key) {
  const auto region = section.optional<std::vector<double>>(key, {});
  if (region.empty()) return std::nullopt;
  if (region.size() != 4 || region[0] >= region[2] || region[1] >= region[3])
    section.fail(key, std::string(key) + " needs [x1, y1, x2, y2] with x1 < x2 and y1 < y2");
  return RegionGoal{{region[0], region[1]}, {region[2], region[3]}};
}

double read_positive(Section& section, const char* key, double value) {
  value = section.optional(key, value);
  if (!(value > 0.0)) section.fail(key, std::string("`") + key + "` must be above 0");
  return value;
}

// Reads all fields of a pose goal except the pose.
PoseGoal read_tolerances(Section& section) {
  PoseGoal goal;
  goal.tolerance = read_positive(section, "tolerance", goal.tolerance);
  goal.heading_tolerance = read_positive(section, "heading_tolerance", goal.heading_tolerance);
  goal.stand = section.optional("stand", goal.stand);
  if (goal.stand < 0.0) section.fail("stand", "`stand` must be 0 or more");
  return goal;
}

std::string read_edge(Section& section) {
  const auto edge = section.optional<std::string>("of", "");
  if (!edge.empty() && edge != "front" && edge != "rear" && edge != "left" && edge != "right")
    section.fail("of", "`of` = " + edge + " is none of front, rear, left, right");
  return edge;
}

Goal read_goal(const YAML::Node& node, const std::string& path, Scenario& scenario) {
  Section goal{node, path};
  scenario.goals = read_poses(goal, "poses");
  scenario.after = read_region(goal, "after");
  scenario.goal_edge = read_edge(goal);
  const auto& poses = scenario.goals;
  const auto region = read_region(goal, "region");
  const auto at = goal.optional<std::vector<double>>("pose", {});
  PoseGoal pose_goal = read_tolerances(goal);
  const double time = goal.optional("roam_time", 0.0);
  const double distance = goal.optional("roam_distance", 0.0);
  goal.finish();
  if ((region ? 1 : 0) + (at.empty() ? 0 : 1) + (poses.empty() ? 0 : 1) + (time > 0.0 ? 1 : 0) != 1)
    fail(path, node,
         "goal needs one of region: [x1, y1, x2, y2], pose: [x, y, heading], "
         "poses: [x1, y1, heading1, …], roam_time");
  if (region && !scenario.goal_edge.empty() && !scenario.after)
    goal.fail("of", "`of` is about a pose or `after`");
  if (region) return *region;
  if (time > 0.0) return RoamGoal{time, distance};
  pose_goal.X_MG = poses.empty() ? pose(at, path + ": goal.pose") : poses.front();
  return pose_goal;
}

std::vector<Eigen::Vector2d> read_points(Section& section, const char* key) {
  const auto numbers = section.required<std::vector<double>>(key);
  if (numbers.empty() || numbers.size() % 2 != 0)
    section.fail(key, std::string("`") + key + "` needs x1, y1, x2, y2, … [m]");
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < numbers.size(); i += 2)
    points.emplace_back(numbers[i], numbers[i + 1]);
  return points;
}

double read_above(Section& section, const char* key, double value, double least) {
  value = section.optional(key, value);
  if (!(value >= least && value <= kMostOfAPerson))
    section.fail(key, fmt::format("`{}` outside [{}, {}]", key, least, kMostOfAPerson));
  return value;
}

Crossings read_crossings(Section& section) {
  Crossings crossings;
  crossings.count = section.required<int>("crossings");
  if (crossings.count < 0 || crossings.count > kMostPeople)
    section.fail("crossings", fmt::format("`crossings` outside [0, {}] people", kMostPeople));
  const auto area = read_points(section, "area");
  if (area.size() != 2 || !(area[0].array() < area[1].array()).all())
    section.fail("area", "`area` needs [x1, y1, x2, y2] with x1 < x2 and y1 < y2");
  crossings.low = area[0];
  crossings.high = area[1];
  crossings.slowest = read_above(section, "slowest", crossings.slowest, 0.0);
  crossings.fastest = read_above(section, "fastest", crossings.fastest, crossings.slowest);
  crossings.radius = read_above(section, "radius", crossings.radius, kThinnest);
  return crossings;
}

void read_people(const YAML::Node& node, Scenario& scenario) {
  if (!node || node.IsNull()) return;
  if (!node.IsSequence()) fail(scenario.path, node, "`people` needs a list of them");
  for (const auto& entry : node) {
    Section section{entry, scenario.path};
    if (entry["crossings"]) {
      scenario.crossings.push_back(read_crossings(section));
    } else {
      Walker walker;
      walker.p_MW = read_points(section, "way");
      walker.speed = read_above(section, "speed", walker.speed, 0.0);
      walker.radius = read_above(section, "radius", walker.radius, kThinnest);
      scenario.people.push_back(std::move(walker));
    }
    section.finish();
  }
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
    values[key] = {yaml_text(node[key]), path + ":" + std::to_string(node[key].Mark().line + 1)};
  return values;
}

std::map<std::string, Values> read_parameters(const YAML::Node& node, const std::string& path) {
  static const std::vector<std::string> components = drive_components();
  std::map<std::string, Values> all;
  if (!node || node.IsNull()) return all;
  for (const auto& name : keys_of(node, path)) {
    if (std::find(components.begin(), components.end(), name) == components.end())
      fail(path, node[name],
           "parameters for `" + name + "`, which is none of " + joined(components));
    all[name] = read_values(node[name], path);
    rt::check_parameters(name, {.name = name, .parameters = {.values = all[name]}});
  }
  return all;
}

}  // namespace

std::map<std::string, std::map<std::string, rt::ParameterValue>> component_parameters(
    const YAML::Node& node, const std::string& path) {
  return read_parameters(node, path);
}

Scenario load_scenario(const std::string& path) {
  Section file{load_document(path), path};
  Scenario s;
  s.path = path;
  s.name = read_name(file);
  (void)file.optional<std::string>("about", "");
  s.map = file.required<std::string>("map");
  if (s.map != "clutter") s.map = beside(path, s.map);
  s.robot = beside(path, file.required<std::string>("robot"));
  if (std::filesystem::is_directory(s.robot))
    file.fail("robot", "`robot` = " + s.robot + " is a folder; name a robot's file in it");
  if (const auto fixtures = file.optional<std::string>("fixtures", ""); !fixtures.empty())
    s.fixtures = beside(path, fixtures);
  s.map_source = file.optional<std::string>("map_source", s.map_source);
  s.start = pose(file.required<std::vector<double>>("start"), path + ": start");
  s.goal = read_goal(file.required_child("goal"), path, s);
  s.method = file.required<std::string>("method");
  s.methods = file.optional<std::vector<std::string>>("methods", {s.method});
  if (s.methods.empty())
    file.fail("methods",
              "`methods` is empty; list one at least, or leave the key out: then it is `method`");
  s.driver = file.optional("driver", s.driver);
  if (const auto recording = file.optional<std::string>("recording", ""); !recording.empty())
    s.recording = beside(path, recording);
  s.recording_topic = file.optional<std::string>("recording_topic", "");
  s.duration = file.optional("duration", s.duration);
  s.seed = file.optional("seed", s.seed);
  s.slice = read_values(file.child("slice"), path);
  s.parameters = read_parameters(file.child("parameters"), path);
  read_people(file.child("people"), s);
  s.expect = read_expectation(file.child("expect"), path);
  file.finish();
  if (!(s.duration > 0.0 && s.duration <= kLongest))
    file.fail("duration",
              fmt::format("`duration` = {} outside (0, {}]: [s] simulated, then the drive is over",
                          s.duration, kLongest));
  check_scenario(s);
  return s;
}

}  // namespace tandem
