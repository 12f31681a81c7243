// SPDX-License-Identifier: Apache-2.0
// Lists the worlds, robots and drives on which the loss of poses is measured.
#pragma once

#include <utility>
#include <vector>

#include "obstacle_extractor/lost_poses.hpp"
#include "obstacle_extractor/worlds.hpp"
#include "tandem/map/barn_world.hpp"

namespace tandem::test {

struct LossWorld {
  std::shared_ptr<const StaticMap> map;
  ReachablePoses reachable;
  std::vector<Eigen::Vector2d> goals;
};

struct LossWorlds {
  const char* name;
  Footprint footprint;
  double width;  // [m] of the robot
  std::vector<LossWorld> worlds;

  [[nodiscard]] Loss measure(ExtractorParams params, double disc_overhang = 0.0) const {
    params.width = width;
    Loss loss;
    for (const LossWorld& world : worlds)
      loss.add(
          measure_loss(world.map, footprint, world.reachable, world.goals, params, disc_overhang));
    return loss;
  }
};

inline constexpr double kMirWidth = 0.58, kJackalWidth = 0.43;  // [m]
inline const Footprint kMir = rectangle(0.89, kMirWidth, 0.038);
inline const Footprint kJackal = rectangle(0.508, kJackalWidth, 0.0);

/// Every n-th BARN world with a Jackal, from its start to its goal.
inline LossWorlds barn_loss_worlds(int every) {
  LossWorlds group{"BARN, Jackal", kJackal, kJackalWidth, {}};
  const auto numbers = barn_world_numbers(barn_file());
  for (std::size_t i = 0; i < numbers.size(); i += static_cast<std::size_t>(every)) {
    const auto map = barn_world(numbers[i]);
    group.worlds.push_back(
        {map, ReachablePoses(map, kJackal, {-2.25, 3.0}), {Eigen::Vector2d{-2.25, 13.0}}});
  }
  return group;
}

/// The real building, with drives from its corridor to random positions.
inline LossWorlds building_loss_worlds(const char* name, const Footprint& footprint, double width,
                                       int drives) {
  const auto map = load_world(building_map());
  LossWorld world{map, ReachablePoses(map, footprint, {-1.0, 0.0}), {}};
  for (int i = 0; i < drives; ++i)
    world.goals.push_back(world.reachable.some_place(static_cast<unsigned>(i)));
  LossWorlds group{name, footprint, width, {}};
  group.worlds.push_back(std::move(world));
  return group;
}

inline std::vector<LossWorlds> loss_worlds(int every) {
  std::vector<LossWorlds> all;
  all.push_back(barn_loss_worlds(every));
  all.push_back(building_loss_worlds("geb079, Jackal", kJackal, kJackalWidth, 12));
  all.push_back(building_loss_worlds("geb079, MiR", kMir, kMirWidth, 12));
  return all;
}

}  // namespace tandem::test
