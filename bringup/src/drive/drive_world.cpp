// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive/drive_world.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/shortest_path.hpp"
#include "tandem/map/map_file.hpp"
#include "tandem/map/overlay.hpp"
#include "tandem/obstacle_extractor/obstacle_extractor_node.hpp"
#include "tandem/safety_filter/safety_filter_node.hpp"

namespace tandem {
namespace {

std::shared_ptr<const StaticMap> empty_world() { return std::make_shared<const StaticMap>(Grid{}); }

// The true obstacles. Virtual fixtures are added by the components, not here.
std::shared_ptr<const StaticMap> world_of(const DiffDriveSimNodeParams& sim,
                                          const DriveOptions& options) {
  if (!options.obstacles) return empty_world();
  return std::make_shared<const StaticMap>(slice(*load_map(sim.map), sim.slice),
                                           sim.unknown_is_obstacle);
}

// The part of the world that is known at the start.
std::shared_ptr<const StaticMap> map_of(const DiffDriveSimNodeParams& sim,
                                        const MapInputParams& params, const DriveOptions& options) {
  if (!options.obstacles) return empty_world();
  if (params.map_source == "local")
    return std::make_shared<const StaticMap>(Grid{}, params.unknown_is_obstacle);
  return static_map(*load_map(sim.map), params, fixtures_of(params));
}

// Names and values of all parameters, as part of a world's key.
template <class P>
std::string text_of(P params) {
  std::string text;
  params.visit([&](const char* name, const auto& value, const auto&...) {
    if constexpr (std::ranges::range<decltype(value)>)
      text += fmt::format("{}={};", name, fmt::join(value, ","));
    else
      text += fmt::format("{}={};", name, value);
  });
  return text;
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

}  // namespace

Grid base_of(const DiffDriveSimNodeParams& sim, const MapInputParams& params) {
  const Grid grid = params.map_source == "local" ? Grid{} : slice(*load_map(sim.map), params.slice);
  return with_forbidden(grid, fixtures_of(params));
}

Grid known_ground_of(const DiffDriveSimNodeParams& sim, const MapInputParams& params) {
  return params.map_source == "both" ? with_known_ground(slice(*load_map(sim.map), params.slice))
                                     : Grid{};
}

SimulatedScan scan_of(const DiffDriveSim& sim, const DiffDriveSimNodeParams& params) {
  const auto angle = [&](int i) { return beam_angle(i, params.scan_beams, params.scan_angle); };
  SimulatedScan scan;
  scan.form.angle_min = angle(0);
  scan.form.angle_increment = angle(1) - angle(0);
  scan.form.range_max = params.scan_range;
  for (int i = 0; i < params.scan_beams; ++i)
    scan.ranges.push_back(scan_range_of(sim, params, sim.state().X_MB, i));
  return scan;
}

LiveSensing::LiveSensing(const OctomapBuilderNodeParams& builder)
    : outline_{footprint_of(builder.robot)},
      sweep_height_{sweep_height(builder)},
      X_BS_{mounting("scan_pose", builder.scan_pose).value_or(scanner_place())},
      map_{builder.map},
      body_{outline_},
      reader_{builder.scan, builder.map.min_range},
      watch_{"scan", builder.watch, builder.map.resolution} {}

void LiveSensing::on_odometry(const RobotState& robot, const Pose2& X_WB, double stamp, double t) {
  poses_.add(robot.X_MB, robot.twist, stamp);
  odometry_.add(X_WB, robot.twist, stamp);
  map_.stand(outline_, robot.X_MB, sweep_height_, t);
}

std::optional<Grid> LiveSensing::look(const RangeScan& scan, const SliceParams& params, double t) {
  auto before = std::exchange(seen_, std::nullopt);
  const auto X_MB = poses_.at(t);
  if (!X_MB) return before;
  const ScanReading reading = reader_.read(scan, X_BS_, body_);
  if (!reading.error.empty()) {
    watch_.on_trouble(reading.error, t);
    return before;
  }
  const LookUse use = watch_.assess({reading.seen, X_BS_, odometry_.at(t), reading.valid_share},
                                    reading.composition, t);
  if (use == LookUse::kNone) return before;
  const Look look{reading.seen, in_space(*X_MB) * X_BS_};
  if (use == LookUse::kTake && !map_.insert({&look, 1}, t)) return before;
  watch_.on_taken(t);
  seen_ = slice(map_.tree(), params);
  return before;
}

template <class Make>
World& Worlds::at(const std::string& key, Make make) {
  const auto known = std::find_if(worlds_.begin(), worlds_.end(),
                                  [&](const auto& world) { return world->key == key; });
  if (known != worlds_.end()) {
    std::rotate(known, known + 1, worlds_.end());  // the most recently used world is last
    return *worlds_.back();
  }
  if (worlds_.size() >= kMaxWorlds) worlds_.erase(worlds_.begin());
  worlds_.push_back(std::make_unique<World>(make()));
  return *worlds_.back();
}

World& Worlds::of(const Scenario& scenario, const System& system, const DriveOptions& options) {
  const auto sim = parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim");
  const auto filter = parameters_of<SafetyFilterNodeParams>(system, "safety_filter").map;
  const auto extractor = parameters_of<ObstacleExtractorNodeParams>(system, "obstacle_extractor");
  const std::string key = scenario.map + text_of(sim.slice) + text_of(sim.robot) + text_of(filter) +
                          text_of(extractor.map) + text_of(extractor.robot) +
                          text_of(extractor.extractor) + text_of_place(scenario) +
                          fmt::format(";{};{}", sim.unknown_is_obstacle, options.obstacles);
  const bool live = is_seen_live(filter);
  if (live) std::erase_if(worlds_, [&](const auto& world) { return world->key == key; });
  return at(key, [&] {
    const auto truth = world_of(sim, options);
    const auto filter_map = live ? nullptr : map_of(sim, filter, options);
    return World{key, truth, filter_map,
                 Extractor{map_of(sim, extractor.map, options), extractor_for_robot(extractor)},
                 shortest_path(*truth, footprint_of(sim.robot), scenario.start, scenario.goal)};
  });
}

}  // namespace tandem
