// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_worlds.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
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

}  // namespace

void write_worlds(const Study& study, const StudyFolder& folder) {
  json all = kept(folder);
  for (const StudyDrive& drive : study.drives) {
    const auto finished = folder.finished().find(name_of(study, drive));
    if (finished == folder.finished().end()) continue;
    const StudyCell& cell = study.cells[drive.cell];
    const fs::path map = finished->second.at("drive").at("map").get<std::string>();
    const bool is_new = !all.contains(cell.scenario.name);
    if (!is_new && (all[cell.scenario.name]["worlds"].contains(map.filename().string()) ||
                    all[cell.scenario.name]["worlds"].size() >= kMaxWorlds))
      continue;
    Scenario scenario = cell.scenario;
    scenario.map = map.string();
    const auto sim =
        parameters_of<DiffDriveSimNodeParams>(system_of(scenario, cell.options), "diff_drive_sim");
    if (is_new) all[cell.scenario.name] = scene_of(scenario, sim);
    if (fs::exists(map))
      all[cell.scenario.name]["worlds"][map.filename().string()] =
          cells_of(slice(*load_map(map.string()), sim.slice));
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
