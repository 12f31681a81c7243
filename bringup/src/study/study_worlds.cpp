// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_worlds.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include "tandem/config/json_text.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/map/map_file.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMaxWorlds = 4;  // per scenario

double rounded(double metres) { return std::round(metres * 1000.0) / 1000.0; }

json cells_of(const Grid& grid) {
  json cells = json::array();
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix) {
      if (grid.at(ix, iy) != Cell::kOccupied) continue;
      const Eigen::Vector2d p = grid.center(ix, iy);
      cells.push_back({rounded(p.x()), rounded(p.y())});
    }
  return {{"resolution", grid.resolution}, {"cells", cells}};
}

json goal_of(const Scenario& scenario) {
  const Goal& goal = scenario.goal;
  if (!scenario.goals.empty()) {
    json poses = json::array();
    for (const Pose2& X : scenario.goals) poses.push_back({X.x, X.y, X.theta});
    return {{"poses", poses}, {"tolerance", std::get<PoseGoal>(goal).tolerance}};
  }
  if (const auto* region = std::get_if<RegionGoal>(&goal))
    return {{"region", {region->low.x(), region->low.y(), region->high.x(), region->high.y()}}};
  if (const auto* at = std::get_if<PoseGoal>(&goal))
    return {{"pose", {at->X_MG.x, at->X_MG.y, at->X_MG.theta}}, {"tolerance", at->tolerance}};
  return json::object();
}

json outline_of(const RobotParams& robot) {
  json parts = json::array();
  for (const auto& part : footprint_of(robot).parts) {
    json points = json::array();
    for (const auto& p_BV : part) points.push_back({p_BV.x(), p_BV.y()});
    parts.push_back(points);
  }
  return parts;
}

json scene_of(const Scenario& scenario, const DiffDriveSimNodeParams& sim) {
  return {{"start", {scenario.start.x, scenario.start.y, scenario.start.theta}},
          {"outline", outline_of(sim.robot)},
          {"goal", goal_of(scenario)},
          {"worlds", json::object()}};
}

std::string file_of(const StudyFolder& folder) { return folder.path() + "/worlds.json"; }

bool is_scene(const json& scene) {
  return scene.is_object() && scene.contains("worlds") && scene["worlds"].is_object();
}

json kept(const StudyFolder& folder) {
  const std::string file = file_of(folder);
  if (!fs::exists(file)) return json::object();
  std::ifstream in{file};
  json all = parse_json_or_null(in);
  if (all.is_object() && std::all_of(all.begin(), all.end(), is_scene)) return all;
  throw std::runtime_error(file + ": is damaged; remove it (it is used only to draw pictures): " +
                           "`tandem study FILE --out " + folder.path() + "` writes it again");
}

// The maps that the finished drives of a scenario have with the smallest seeds.
std::vector<std::string> maps_driven(const StudyFolder& folder, const std::string& scenario) {
  std::vector<std::string> maps;
  folder.results().query(
      "SELECT map FROM drives WHERE scenario = ? GROUP BY map ORDER BY min(seed), map LIMIT " +
          std::to_string(kMaxWorlds),
      {scenario}, [&](const SqliteStatement& row) { maps.push_back(sql::text(row, 0)); });
  return maps;
}

}  // namespace

void write_worlds(const Study& study, const StudyFolder& folder) {
  json all = kept(folder);
  std::set<std::string> seen;
  for (const StudyCell& cell : study.cells) {
    if (!seen.insert(cell.scenario.name).second) continue;
    const auto maps = maps_driven(folder, cell.scenario.name);
    if (maps.empty()) continue;
    Scenario scenario = cell.scenario;
    scenario.map = maps.front();
    const auto sim =
        parameters_of<DiffDriveSimNodeParams>(system_of(scenario, cell.options), "diff_drive_sim");
    if (!all.contains(scenario.name)) all[scenario.name] = scene_of(scenario, sim);
    json& worlds = all[scenario.name]["worlds"];
    for (const std::string& map : maps) {
      const std::string name = fs::path(map).filename();
      if (!worlds.contains(name) && worlds.size() < kMaxWorlds && fs::exists(map))
        worlds[name] = cells_of(slice(*load_map(map), sim.slice));
    }
  }
  write_file(file_of(folder), all.dump() + "\n");
}

void merge_worlds(const StudyFolder& from, const StudyFolder& into) {
  json all = kept(into);
  const json more = kept(from);
  for (const auto& [scenario, scene] : more.items()) {
    if (!all.contains(scenario)) all[scenario] = scene;
    for (const auto& [map, world] : scene.at("worlds").items()) {
      auto& worlds = all[scenario]["worlds"];
      if (worlds.contains(map) || worlds.size() < kMaxWorlds) worlds[map] = world;
    }
  }
  write_file(file_of(into), all.dump() + "\n");
}

}  // namespace tandem
