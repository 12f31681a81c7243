// SPDX-License-Identifier: Apache-2.0
// The world of a drive as it is, whatever the robot knows of it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bringup/scenario/scenario.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/runtime/result_cache.hpp"

namespace tandem {

/// The true obstacles, and the shortest path through them to the goal.
struct DriveWorld {
  std::shared_ptr<const StaticMap> map;
  std::optional<double> shortest_path;  ///< [m]
};

/// The world of a drive. Throws what load_map and slice throw.
[[nodiscard]] DriveWorld drive_world(const Scenario& scenario, const System& system);
/// The same; the map is shared with the simulators on the buses of that cache.
[[nodiscard]] DriveWorld drive_world(const Scenario& scenario, const System& system,
                                     rt::ResultCache& cache);

/// Throws std::invalid_argument if the start or the goal (of a region, the centre) is outside the
/// map, if the start is in an obstacle, or if the map's slice has no occupied cell, which hints at
/// wrong slice heights.
void check_places(const Scenario& scenario, const System& system, const StaticMap& world);

/// Keeps the most recently used worlds, which speeds up repeated drives in one of them.
class DriveWorlds {
 public:
  explicit DriveWorlds(std::shared_ptr<rt::ResultCache> cache) : cache_{std::move(cache)} {}
  /// As drive_world().
  [[nodiscard]] DriveWorld of(const Scenario& scenario, const System& system);

 private:
  static constexpr std::size_t kMaxWorlds = 24;
  struct Kept {
    std::string key;  // every input that the world depends on
    DriveWorld world;
  };
  std::shared_ptr<rt::ResultCache> cache_;
  std::vector<Kept> worlds_;
};

}  // namespace tandem
