// SPDX-License-Identifier: Apache-2.0
// In: how many. Out: the worlds, robots and drives that the loss of poses is measured on.
#pragma once

#include <utility>
#include <vector>

#include "lost_poses.hpp"
#include "map/barn_world.hpp"
#include "worlds.hpp"

namespace tandem::test {

struct LossWorld {
  std::shared_ptr<const StaticMap> map;
  ReachablePoses reachable;
  std::vector<Eigen::Vector2d> goals;
};

struct LossWorlds {
  const char* name;
  Footprint footprint;
  std::vector<LossWorld> worlds;

  [[nodiscard]] Loss measure(const ExtractorParams& params, double disc_overhang = 0.0) const {
    Loss loss;
    for (const LossWorld& world : worlds)
      loss.add(
          measure_loss(world.map, footprint, world.reachable, world.goals, params, disc_overhang));
    return loss;
  }
};

inline const Footprint kMir = rectangle(0.89, 0.58, 0.038);
inline const Footprint kJackal = rectangle(0.508, 0.43, 0.0);

/// Every n-th BARN world with a Jackal, from its start to its goal.
inline LossWorlds barn_loss_worlds(int every) {
  LossWorlds group{"BARN, Jackal", kJackal, {}};
  const auto numbers = barn_world_numbers(barn_file());
  for (std::size_t i = 0; i < numbers.size(); i += static_cast<std::size_t>(every)) {
    const auto map = barn_world(numbers[i]);
    group.worlds.push_back(
        {map, ReachablePoses(map, kJackal, {-2.25, 3.0}), {Eigen::Vector2d{-2.25, 13.0}}});
  }
  return group;
}

/// The real building, with drives from its corridor to places anywhere.
inline LossWorlds building_loss_worlds(const char* name, const Footprint& footprint, int drives) {
  const auto map = load_world(building_map());
  LossWorld world{map, ReachablePoses(map, footprint, {-1.0, 0.0}), {}};
  for (int i = 0; i < drives; ++i)
    world.goals.push_back(world.reachable.some_place(static_cast<unsigned>(i)));
  LossWorlds group{name, footprint, {}};
  group.worlds.push_back(std::move(world));
  return group;
}

inline std::vector<LossWorlds> loss_worlds(int every) {
  std::vector<LossWorlds> all;
  all.push_back(barn_loss_worlds(every));
  all.push_back(building_loss_worlds("geb079, Jackal", kJackal, 12));
  all.push_back(building_loss_worlds("geb079, MiR", kMir, 12));
  return all;
}

}  // namespace tandem::test
