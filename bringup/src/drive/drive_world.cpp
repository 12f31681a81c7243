// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/drive_world.hpp"

#include <algorithm>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/shortest_path.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"

namespace tandem {
namespace {

DiffDriveSimNodeParams simulator_in(const System& system) {
  return parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim");
}

std::string text_of_place(const Scenario& scenario) {
  const Pose2& X = scenario.start;
  std::string text = fmt::format("{},{},{};", X.x, X.y, X.theta);
  if (const auto* region = std::get_if<RegionGoal>(&scenario.goal))
    text += fmt::format("{},{},{},{}", region->low.x(), region->low.y(), region->high.x(),
                        region->high.y());
  if (const auto* at = std::get_if<PoseGoal>(&scenario.goal))
    text += fmt::format("{},{},{}", at->X_MG.x, at->X_MG.y, at->tolerance);
  return text;
}

void require_on_map(const char* key, const Eigen::Vector2d& p_M, const Scenario& scenario,
                    const Grid& grid) {
  const Eigen::Vector2d end =
      grid.origin + grid.resolution * Eigen::Vector2d(grid.width, grid.height);
  if ((p_M.array() >= grid.origin.array()).all() && (p_M.array() <= end.array()).all()) return;
  throw std::invalid_argument(fmt::format(
      "{}: [{}, {}] is outside {}, which has x from {:.1f} to {:.1f} and y from "
      "{:.1f} to {:.1f} m",
      key, p_M.x(), p_M.y(), scenario.map, grid.origin.x(), end.x(), grid.origin.y(), end.y()));
}

}  // namespace

DriveWorld drive_world(const Scenario& scenario, const System& system, rt::ResultCache& cache) {
  const auto sim = simulator_in(system);
  auto map = cache.get<const StaticMap>(key_of_world(sim), [&] { return simulated_world(sim); });
  const auto length = shortest_path(*map, footprint_of(sim.robot), scenario.start, scenario.goal);
  return {std::move(map), length};
}

DriveWorld drive_world(const Scenario& scenario, const System& system) {
  rt::ResultCache none{1};
  return drive_world(scenario, system, none);
}

void check_places(const Scenario& scenario, const System& system, const StaticMap& world) {
  const auto sim = simulator_in(system);
  const auto& cells = world.grid().cells;
  if (!sim.unknown_is_obstacle &&
      std::find(cells.begin(), cells.end(), Cell::kOccupied) == cells.end())
    throw std::invalid_argument(
        fmt::format("{} contains nothing between {} m and {} m above the floor at {} m; check "
                    "z_min, z_max and floor",
                    scenario.map, sim.slice.z_min, sim.slice.z_max, sim.slice.floor));
  const Pose2& X = scenario.start;
  require_on_map("start", X.position(), scenario, world.grid());
  if (const auto* region = std::get_if<RegionGoal>(&scenario.goal))
    require_on_map("goal", 0.5 * (region->low + region->high), scenario, world.grid());
  if (const auto* at = std::get_if<PoseGoal>(&scenario.goal))
    require_on_map("goal", at->X_MG.position(), scenario, world.grid());
  if (world.clearance(footprint_of(sim.robot), X, 1.0) <= 0.0)
    throw std::invalid_argument(fmt::format(
        "start: at [{}, {}, {}] the robot's outline overlaps an obstacle", X.x, X.y, X.theta));
}

DriveWorld DriveWorlds::of(const Scenario& scenario, const System& system) {
  const auto sim = simulator_in(system);
  const std::string key = key_of_world(sim) + parameter_text(sim.robot) + text_of_place(scenario);
  const auto known = std::find_if(worlds_.begin(), worlds_.end(),
                                  [&](const Kept& kept) { return kept.key == key; });
  if (known != worlds_.end()) {
    std::rotate(known, known + 1, worlds_.end());  // the most recently used world is last
    return worlds_.back().world;
  }
  if (worlds_.size() >= kMaxWorlds) worlds_.erase(worlds_.begin());
  worlds_.push_back({key, drive_world(scenario, system, *cache_)});
  return worlds_.back().world;
}

}  // namespace tandem
