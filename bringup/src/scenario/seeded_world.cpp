// SPDX-License-Identifier: Apache-2.0
#include "bringup/scenario/seeded_world.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/checksum.hpp"
#include "tandem/map/barn_world.hpp"
#include "tandem/map/clutter_world.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/path_search.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/runtime/result_cache.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr double kRadiusStep = 0.02;  // [m] between the radii tried for the widest path
constexpr std::size_t kKeptWorlds = 64;

const char* const kClutter = "clutter";

struct World {
  std::string name;
  MapDescription description;
};

// No wrap-around: it would repeat worlds under other seeds.
int number_of(const std::string& family, unsigned seed) {
  const auto numbers = barn_world_numbers(family);
  if (seed >= 1 && seed <= numbers.size()) return numbers[seed - 1];
  throw std::invalid_argument(
      fmt::format("{}: seed {} is not one of its worlds; name seeds from 1 to {}", family, seed,
                  numbers.size()));
}

World world_of(const std::string& family, unsigned seed) {
  if (family == kClutter) return {fmt::format("clutter_{}", seed), clutter_world(seed, {})};
  const int number = number_of(family, seed);
  return {fmt::format("{}_{}", fs::path(family).stem().string(), number),
          load_barn_world(family, number)};
}

// Renames atomically, because other processes may be reading the file. The name contains a checksum
// of the content: generators may share a name, and worlds are identified by their files.
fs::path save(const octomap::OcTree& tree, const std::string& world) {
  const std::string bytes = bt_file_bytes(tree);
  const std::string name =
      fmt::format("{}_{:08x}", world, static_cast<std::uint32_t>(checksum(bytes)));
  const fs::path folder = fs::temp_directory_path() / fmt::format("tandem_worlds_{}", geteuid());
  const fs::path file = folder / (name + ".bt");
  std::error_code none;
  if (fs::file_size(file, none) == bytes.size()) return file;
  fs::create_directories(folder);
  const fs::path part = folder / fmt::format("{}.{}.part", name, getpid());
  save_bt_file(bytes, part);
  fs::rename(part, file);
  return file;
}

// The path for the largest of some radii that fits; empty if none does. A disc fits wherever a
// larger one does, so a bisection finds that radius.
std::vector<Eigen::Vector2d> widest_path(const StaticMap& map, const Eigen::Vector2d& from,
                                         const Eigen::Vector2d& to) {
  std::vector<double> radii;
  for (double radius = 0.5; radius > 0.0; radius -= kRadiusStep) radii.push_back(radius);
  const auto widest = std::partition_point(
      radii.begin(), radii.end(), [&](double radius) { return !has_path(map, from, to, radius); });
  return widest == radii.end() ? std::vector<Eigen::Vector2d>{} : find_path(map, from, to, *widest);
}

std::string route(const StaticMap& map, const Pose2& start, const Goal& goal) {
  const auto place = place_of(goal);
  if (!place) throw std::invalid_argument("a world by seed needs a goal with a place");
  const auto way = widest_path(map, start.position(), *place);
  if (way.empty()) throw std::runtime_error("no way from start to goal");
  std::string text;
  for (const auto& p : way)
    text += fmt::format("{}{:.3f}, {:.3f}", text.empty() ? "[" : ", ", p.x(), p.y());
  return text + "]";
}

// A world of a family as a file. `route`, as the driver's parameter, is the widest path through it,
// or empty if the scenario sets one.
struct SavedWorld {
  std::string file, route;
};

bool needs_route(const Scenario& scenario) {
  const auto driver = scenario.parameters.find("driver");
  return driver == scenario.parameters.end() || !driver->second.contains("route");
}

SavedWorld make_world(const Scenario& scenario) {
  const World world = world_of(scenario.map, scenario.seed);
  const auto tree = build_octomap(world.description);
  const std::string file = save(*tree, world.name).string();
  if (!needs_route(scenario)) return {file, {}};
  return {file, route(StaticMap{slice(*tree, {})}, scenario.start, scenario.goal)};
}

// Each drive asks several times, and those by other methods ask for the same world.
SavedWorld saved_world(const Scenario& scenario) {
  static std::mutex mutex;
  static rt::ResultCache worlds{kKeptWorlds};
  const Pose2& X = scenario.start;
  const Eigen::Vector2d goal = place_of(scenario.goal).value_or(Eigen::Vector2d::Zero());
  const std::string key =
      fmt::format("{} {} {} {} {} {} {} {}", file_key(scenario.map), scenario.seed, X.x, X.y,
                  X.theta, goal.x(), goal.y(), needs_route(scenario));
  const std::lock_guard lock{mutex};
  const auto make = [&] { return std::make_shared<SavedWorld>(make_world(scenario)); };
  auto world = worlds.get<SavedWorld>(key, make);
  if (!fs::exists(world->file)) *world = make_world(scenario);
  return *world;
}

}  // namespace

bool is_family(const std::string& map) {
  return map == kClutter || fs::path(map).extension() == ".json";
}

void check_seed(const std::string& map, unsigned seed) {
  if (is_family(map) && map != kClutter) (void)number_of(map, seed);
}

Scenario in_its_world(Scenario scenario) {
  const SavedWorld world = saved_world(scenario);
  if (needs_route(scenario)) scenario.parameters["driver"]["route"] = {world.route, scenario.path};
  scenario.map = world.file;
  return scenario;
}

Scenario without_obstacles(Scenario scenario) {
  constexpr double kFarAway = 500.0, kHeight = 0.5;  // [m]; a map must not be empty
  octomap::OcTree tree{0.05};
  tree.updateNode(scenario.start.x + kFarAway, scenario.start.y + kFarAway, kHeight, true);
  scenario.map = save(tree, "empty").string();
  scenario.map_source = "static";
  scenario.fixtures.clear();
  scenario.slice.clear();
  scenario.people.clear();
  scenario.crossings.clear();
  return scenario;
}

Scenario with_its_goal(Scenario scenario) {
  const std::size_t turn = (scenario.seed + scenario.goals.size() - 1) % scenario.goals.size();
  std::get<PoseGoal>(scenario.goal).X_MG = scenario.goals[turn];
  SliceParams params;
  rt::ParameterStore store{"/slice", {.values = scenario.slice}};
  params.visit(store);
  if (!needs_route(scenario)) return scenario;
  const StaticMap map{slice(*load_map(scenario.map), params)};
  scenario.parameters["driver"]["route"] = {route(map, scenario.start, scenario.goal),
                                            scenario.path};
  return scenario;
}

}  // namespace tandem
