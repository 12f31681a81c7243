// SPDX-License-Identifier: Apache-2.0
#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "bringup/drive/drive_log.hpp"
#include "bringup/drive/map_picture.hpp"
#include "bringup/scenario/method.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/map/map_file.hpp"

namespace tandem {
namespace {

constexpr double kFootprintEvery = 0.9;  // [m] along the path
constexpr double kWalkEvery = 0.1;       // [m]

Pen faint(Color color) {
  color.alpha = 0.10;
  return {.color = colors::kRobot, .width = 1.0, .fill = color};
}

void draw_goal(MapPicture& picture, const Goal& goal, const Footprint& footprint) {
  Color inside = colors::kGoal;
  inside.alpha = 0.18;
  const Pen pen{.color = colors::kGoal, .width = 2.0, .dash = 6.0, .fill = inside, .label = "goal"};
  if (const auto* region = std::get_if<RegionGoal>(&goal))
    picture.draw_rectangle({region->low, region->high}, pen);
  if (const auto* at = std::get_if<PoseGoal>(&goal))
    picture.draw_footprint(footprint, at->X_MG, pen);
}

void draw_walks(MapPicture& picture, const DriveLog& log) {
  const Pen pen{.color = colors::kWalker,
                .width = 1.2,
                .dash = 2.0,
                .label = "people's paths and final positions"};
  for (const auto& [id, walk] : log.walks) {
    picture.draw_path(walk.p_MO, pen);
    picture.draw_circle(walk.p_MO.back(), walk.radius, {.color = colors::kWalker, .width = 1.6});
  }
}

void draw_leader(MapPicture& picture, const std::vector<DriveSample>& track) {
  std::vector<Eigen::Vector2d> leader;
  for (const auto& sample : track)
    if (sample.X_ML) leader.push_back(sample.X_ML->position());
  if (leader.size() > 1)
    picture.draw_path(
        leader,
        {.color = colors::kLeader, .width = 1.6, .dash = 4.0, .label = "the person's leader"});
}

void draw_robot(MapPicture& picture, const std::vector<DriveSample>& track,
                const Footprint& footprint) {
  std::vector<Eigen::Vector2d> way;
  double since = kFootprintEvery;
  for (std::size_t i = 0; i < track.size(); ++i) {
    way.push_back(track[i].X_MB.position());
    if (i > 0) since += (way[i] - way[i - 1]).norm();
    if (since < kFootprintEvery) continue;
    since = 0.0;
    picture.draw_footprint(footprint, track[i].X_MB, faint(colors::kRobot));
  }
  picture.draw_path(way, {.color = colors::kRobot, .width = 2.5, .label = "the robot's path"});
  picture.draw_footprint(footprint, track.back().X_MB, {.color = colors::kRobot, .width = 2.0});
}

void draw_contacts(MapPicture& picture, const std::vector<DriveSample>& track) {
  for (std::size_t i = 1; i < track.size(); ++i)
    if (track[i].collisions > track[i - 1].collisions)
      picture.draw_point(track[i].X_MB.position(),
                         {.color = colors::kContact, .width = 12.0, .label = "collision"});
}

std::string title_of(const DriveResult& r) {
  return fmt::format("{} by {}, seed {}: {} after {:.1f} s, {} collisions, closest {:.2f} m",
                     r.scenario, r.method, r.seed, r.reached ? "reached" : "not reached",
                     r.reached ? r.time_to_goal_s : r.simulated_s, r.collisions, r.min_clearance_m);
}

}  // namespace

void remember(DriveLog& log, const std::vector<Obstacle>& seen) {
  auto& known = log.obstacles;
  for (const Obstacle& o : seen) {
    const bool moves = o.v_MO != Eigen::Vector2d::Zero() || log.walks.contains(o.id);
    if (moves) {
      Walk& walk = log.walks[o.id];
      walk.radius = o.a;
      if (walk.p_MO.empty() || (o.p_MO - walk.p_MO.back()).norm() > kWalkEvery)
        walk.p_MO.push_back(o.p_MO);
    } else if (std::none_of(known.begin(), known.end(),
                            [&](const auto& k) { return k.id == o.id; })) {
      known.push_back(o);
    }
  }
}

void draw_drive(const Scenario& scenario, const System& system, const DriveLog& log,
                const std::string& png) {
  const auto sim = parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim");
  const Footprint footprint = footprint_of(sim.robot);
  MapPicture picture{slice(*load_map(sim.map), sim.slice)};
  draw_goal(picture, scenario.goal, footprint);
  picture.draw_obstacles(log.obstacles,
                         {.color = colors::kShape,
                          .width = 1.6,
                          .label = "obstacles near the robot, as the planner saw them"});
  draw_walks(picture, log);
  if (!log.track.empty()) {
    if (steers_leader(drive_method(scenario.method))) draw_leader(picture, log.track);
    draw_robot(picture, log.track, footprint);
    draw_contacts(picture, log.track);
  }
  picture.set_title(title_of(log.result));
  picture.write_png(png);
}

}  // namespace tandem
