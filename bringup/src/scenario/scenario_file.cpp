// SPDX-License-Identifier: Apache-2.0
// Parses a scenario's YAML; errors name file, line and key.
#include <optional>
#include <set>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/method.hpp"
#include "bringup/scenario/scenario.hpp"
#include "bringup/system/shared_files.hpp"
#include "tandem/config/nearest_name.hpp"
#include "tandem/config/yaml_reader.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

using Values = std::map<std::string, rt::ParameterValue>;

constexpr double kLongest = 1e6;  // [s] of a drive
constexpr int kMaxPeople = 100;
constexpr double kMaxOfAPerson = 5.0;  // [m/s, m] speed or radius
constexpr double kThinnest = 0.05;     // [m] radius

Pose2 read_pose(const YamlReader& value) {
  const auto v = value.as<std::vector<double>>();
  if (v.size() != 3) value.fail(value.key() + " needs three numbers: x, y, heading");
  return {v[0], v[1], v[2]};
}

// The name becomes the file name of pictures and tables, so it must not contain a slash.
std::string read_name(const YamlReader& value) {
  const auto name = value.as<std::string>();
  if (name.empty() || name.find('/') != std::string::npos)
    value.fail(value.key() + " = " + name + ": a name needs a letter, and no `/`");
  return name;
}

std::vector<Pose2> read_poses(const std::optional<YamlReader>& value) {
  if (!value) return {};
  const auto numbers = value->as<std::vector<double>>();
  if (numbers.size() % 3 != 0)
    value->fail(value->key() + " needs x1, y1, heading1, x2, … [m, rad]");
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    poses.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return poses;
}

std::optional<RegionGoal> read_region(const std::optional<YamlReader>& value) {
  if (!value) return std::nullopt;
  const auto region = value->as<std::vector<double>>();
  if (region.size() != 4 || region[0] >= region[2] || region[1] >= region[3])
    value->fail(value->key() + " needs [x1, y1, x2, y2] with x1 < x2 and y1 < y2");
  return RegionGoal{{region[0], region[1]}, {region[2], region[3]}};
}

double read_positive(YamlReader& map, const char* key, double otherwise) {
  const auto value = map.optional(key);
  const double number = value ? value->as<double>() : otherwise;
  if (!(number > 0.0)) value->fail(value->key() + " must be above 0");
  return number;
}

// Reads all fields of a pose goal except the pose.
PoseGoal read_tolerances(YamlReader& map) {
  PoseGoal goal;
  goal.tolerance = read_positive(map, "tolerance", goal.tolerance);
  goal.heading_tolerance = read_positive(map, "heading_tolerance", goal.heading_tolerance);
  if (const auto stand = map.optional("stand")) {
    goal.stand = stand->as<double>();
    if (goal.stand < 0.0) stand->fail(stand->key() + " must be 0 or more");
  }
  return goal;
}

std::string read_edge(const std::optional<YamlReader>& value) {
  if (!value) return {};
  const auto edge = value->as<std::string>();
  if (edge != "front" && edge != "rear" && edge != "left" && edge != "right")
    value->fail(value->key() + " = " + edge + " is not one of front, rear, left, right");
  return edge;
}

Goal read_goal(YamlReader map, Scenario& scenario) {
  scenario.goals = read_poses(map.optional("poses"));
  scenario.after = read_region(map.optional("after"));
  const auto edge = map.optional("of"), at = map.optional("pose");
  scenario.goal_edge = read_edge(edge);
  const auto& poses = scenario.goals;
  const auto region = read_region(map.optional("region"));
  PoseGoal pose_goal = read_tolerances(map);
  const double time = map.optional("roam_time", 0.0);
  const double distance = map.optional("roam_distance", 0.0);
  map.finish();
  if ((region ? 1 : 0) + (at ? 1 : 0) + (poses.empty() ? 0 : 1) + (time > 0.0 ? 1 : 0) != 1)
    map.fail(
        "goal needs one of region: [x1, y1, x2, y2], pose: [x, y, heading], "
        "poses: [x1, y1, heading1, …], roam_time");
  if (region && edge && !scenario.after) edge->fail(edge->key() + " is about a pose or `after`");
  if (region) return *region;
  if (time > 0.0) return RoamGoal{time, distance};
  pose_goal.X_MG = at ? read_pose(*at) : poses.front();
  return pose_goal;
}

std::vector<Eigen::Vector2d> read_points(const YamlReader& value) {
  const auto numbers = value.as<std::vector<double>>();
  if (numbers.empty() || numbers.size() % 2 != 0)
    value.fail(value.key() + " needs x1, y1, x2, y2, … [m]");
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < numbers.size(); i += 2)
    points.emplace_back(numbers[i], numbers[i + 1]);
  return points;
}

double read_above(YamlReader& map, const char* key, double otherwise, double least) {
  const auto value = map.optional(key);
  const double number = value ? value->as<double>() : otherwise;
  if (number >= least && number <= kMaxOfAPerson) return number;
  (value ? *value : map).fail(fmt::format("`{}` outside [{}, {}]", key, least, kMaxOfAPerson));
}

Crossings read_crossings(YamlReader& map, const YamlReader& count) {
  Crossings crossings;
  crossings.count = count.as<int>();
  if (crossings.count < 0 || crossings.count > kMaxPeople)
    count.fail(fmt::format("{} outside [0, {}] people", count.key(), kMaxPeople));
  const YamlReader area = map.required("area");
  const auto corners = read_points(area);
  if (corners.size() != 2 || !(corners[0].array() < corners[1].array()).all())
    area.fail(area.key() + " needs [x1, y1, x2, y2] with x1 < x2 and y1 < y2");
  crossings.low = corners[0];
  crossings.high = corners[1];
  crossings.slowest = read_above(map, "slowest", crossings.slowest, 0.0);
  crossings.fastest = read_above(map, "fastest", crossings.fastest, crossings.slowest);
  crossings.radius = read_above(map, "radius", crossings.radius, kThinnest);
  return crossings;
}

Walker read_walker(YamlReader& map) {
  Walker walker;
  walker.p_MW = read_points(map.required("way"));
  walker.speed = read_above(map, "speed", walker.speed, 0.0);
  walker.radius = read_above(map, "radius", walker.radius, kThinnest);
  return walker;
}

void read_people(const YamlReader& list, Scenario& scenario) {
  for (YamlReader& map : list.elements()) {
    if (const auto count = map.optional("crossings"))
      scenario.crossings.push_back(read_crossings(map, *count));
    else
      scenario.people.push_back(read_walker(map));
    map.finish();
  }
}

Expectation read_expectation(YamlReader map) {
  Expectation expect;
  expect.reached = map.optional("reached", expect.reached);
  expect.max_collisions = map.optional("max_collisions", expect.max_collisions);
  expect.max_fallback_share = map.optional("max_fallback_share", expect.max_fallback_share);
  expect.max_final_position_error =
      map.optional("max_final_position_error", expect.max_final_position_error);
  expect.except = map.optional("except", expect.except);
  map.finish();
  return expect;
}

Values read_values(YamlReader map) {
  Values values;
  for (const auto& [key, value] : map.rest()) values[key] = {value.text(), value.place()};
  return values;
}

std::string read_path(YamlReader& map, const char* key) {
  const auto value = map.optional(key);
  return value && !value->as<std::string>().empty() ? value->path() : "";
}

// The files, and the map, which may be a generator's name.
void read_files(YamlReader& file, Scenario& s) {
  const YamlReader map = file.required("map"), robot = file.required("robot");
  s.map = map.as<std::string>();
  if (s.map != "clutter") s.map = find_file(map, "maps");
  s.robot = find_file(robot, "robots");
  s.fixtures = read_path(file, "fixtures");
  s.recording = read_path(file, "recording");
  s.recording_topic = file.optional<std::string>("recording_topic", "");
  s.map_source = file.optional("map_source", s.map_source);
}

void read_methods(YamlReader& file, Scenario& s) {
  s.method = file.required<std::string>("method");
  s.methods = {s.method};
  const auto methods = file.optional("methods");
  if (!methods) return;
  s.methods = methods->as<std::vector<std::string>>();
  if (s.methods.empty())
    methods->fail(
        "`methods` is empty; list one at least, or leave the key out: then it is `method`");
}

double read_duration(YamlReader& file, double otherwise) {
  const auto value = file.optional("duration");
  if (!value) return otherwise;
  const auto duration = value->as<double>();
  if (!(duration > 0.0 && duration <= kLongest))
    value->fail(
        fmt::format("`duration` = {} outside (0, {}]: [s] simulated, then the drive is over",
                    duration, kLongest));
  return duration;
}

}  // namespace

std::map<std::string, Values> component_parameters(YamlReader map) {
  static const std::set<std::string> components = components_of_all_methods();
  std::map<std::string, Values> all;
  for (const auto& [name, values] : map.rest()) {
    if (!components.contains(name))
      values.fail(fmt::format("parameters for `{}`, which is not one of {}{}", name,
                              fmt::join(components, ", "), did_you_mean(name, components)));
    all[name] = read_values(values);
    rt::check_parameters(name, {.name = name, .parameters = {.values = all[name]}});
  }
  return all;
}

Scenario load_scenario(const std::string& path) {
  YamlReader file = YamlReader::load(path);
  Scenario s;
  s.path = path;
  s.name = read_name(file.required("scenario"));
  (void)file.optional("about");
  read_files(file, s);
  s.start = read_pose(file.required("start"));
  s.goal = read_goal(file.required("goal"), s);
  read_methods(file, s);
  s.driver = file.optional("driver", s.driver);
  s.duration = read_duration(file, s.duration);
  s.seed = file.optional("seed", s.seed);
  if (const auto slice = file.optional("slice")) s.slice = read_values(*slice);
  if (const auto all = file.optional("parameters")) s.parameters = component_parameters(*all);
  if (const auto people = file.optional("people")) read_people(*people, s);
  if (const auto expect = file.optional("expect")) s.expect = read_expectation(*expect);
  file.finish();
  check_scenario(s);
  return s;
}

}  // namespace tandem
