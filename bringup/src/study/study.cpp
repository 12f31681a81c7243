// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "bringup/drive/parallel_drives.hpp"
#include "bringup/scenario/method.hpp"
#include "bringup/scenario/seeded_world.hpp"
#include "tandem/map/barn_world.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr double kTrackStep = 0.1;  // [m] between the points of a stored track

nlohmann::json thinned(const std::vector<DriveSample>& track) {
  nlohmann::json points = nlohmann::json::array();
  Eigen::Vector2d last{1e9, 1e9};
  for (std::size_t i = 0; i < track.size(); ++i) {
    const Eigen::Vector2d p = track[i].X_MB.position();
    if ((p - last).norm() < kTrackStep && i + 1 < track.size()) continue;
    points.push_back({std::round(p.x() * 100.0) / 100.0, std::round(p.y() * 100.0) / 100.0});
    last = p;
  }
  return points;
}

// The robot's positions when a collision was counted.
nlohmann::json contacts(const std::vector<DriveSample>& track) {
  nlohmann::json points = nlohmann::json::array();
  for (std::size_t i = 1; i < track.size(); ++i)
    if (track[i].collisions > track[i - 1].collisions)
      points.push_back({track[i].X_MB.x, track[i].X_MB.y});
  return points;
}

// Time that the person takes by hand without obstacles [s].
std::optional<double> free_time(const Scenario& scenario, DriveOptions options,
                                Lockstep& lockstep) {
  if (!place_of(scenario.goal) || !has_person(drive_method(scenario.method))) return std::nullopt;
  options.method = "manual";
  options.map.clear();
  const DriveResult result = lockstep.drive(without_obstacles(scenario), options).result;
  return result.reached ? std::optional{result.time_to_goal_s} : std::nullopt;
}

// CPU time of this process [s].
double cpu_time() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Score of one drive in the BARN challenge; see DriveResult.
std::optional<double> barn_score(const Scenario& scenario, const DriveResult& result) {
  constexpr double kSpeed = 2.0;  // [m/s]
  if (fs::path(scenario.map).extension() != ".json") return std::nullopt;
  const auto way = barn_way_length(scenario.map, barn_world_number(scenario.map, result.seed));
  if (!way) return std::nullopt;
  if (!result.reached || result.collisions > 0) return 0.0;
  const double best = *way / kSpeed;
  return best / std::clamp(result.time_to_goal_s, 2.0 * best, 8.0 * best);
}

}  // namespace

std::string name_of(const Study& study, const StudyDrive& drive) {
  const StudyCell& cell = study.cells[drive.cell];
  return fmt::format("{}/{}/{}/{}", cell.scenario.name, cell.method, cell.driver, drive.seed);
}

void check_study(const Study& study) {
  Lockstep lockstep;
  std::size_t checked = study.cells.size();
  std::map<std::string, unsigned> largest;  // largest seed of each map
  for (const StudyDrive& drive : study.drives) {
    unsigned& seed = largest[study.cells[drive.cell].scenario.map];
    seed = std::max(seed, drive.seed);
  }
  for (const auto& [map, seed] : largest) check_seed(map, seed);
  for (const StudyDrive& drive : study.drives) {
    if (drive.cell == checked) continue;  // already checked with its first seed
    checked = drive.cell;
    check_robot(study.cells[checked].scenario);
    DriveOptions options = study.cells[checked].options;
    options.seed = drive.seed;
    lockstep.check(study.cells[checked].scenario, options);
  }
}

nlohmann::json make_drive(const Study& study, const StudyDrive& drive, Lockstep& lockstep) {
  const double start = cpu_time();
  const StudyCell& cell = study.cells[drive.cell];
  DriveOptions options = cell.options;
  options.seed = drive.seed;
  const Scenario scenario = with_options(cell.scenario, options);
  DriveLog log = lockstep.drive(scenario, options);
  DriveResult& result = log.result;
  result.method = cell.method;
  result.driver = cell.driver;
  result.free_time_s = free_time(scenario, options, lockstep);
  if (result.reached && result.free_time_s)
    result.time_ratio = result.time_to_goal_s / *result.free_time_s;
  result.barn_score = barn_score(cell.scenario, result);
  return {{"drive", result},
          {"track", thinned(log.track)},
          {"contacts", contacts(log.track)},
          {"cost_s", cpu_time() - start}};
}

}  // namespace tandem
