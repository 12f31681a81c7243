// SPDX-License-Identifier: Apache-2.0
// Selects by seed the world and the goal of a scenario that has several.
#pragma once

#include <string>

#include "bringup/scenario/scenario.hpp"

namespace tandem {

/// Whether `map` names a map generator instead of an OctoMap: the word `clutter`, or a JSON file of
/// BARN worlds.
[[nodiscard]] bool is_family(const std::string& map);

/// Throws std::invalid_argument if the map is a file of worlds without one for the seed, which is
/// a world's position in the file, starting at 1; std::runtime_error if it is not such a file.
void check_seed(const std::string& map, unsigned seed);

/// The scenario in the world that belongs to its seed: clutter of that seed, or the seed-th world
/// of the file. Writes the world's OctoMap into the system's folder for temporary files, under a
/// name derived from its content. Unless the scenario sets a route, the driver gets the widest path
/// from the start to the center of the goal. Throws std::runtime_error or std::invalid_argument
/// with a one-line reason.
[[nodiscard]] Scenario in_its_world(Scenario scenario);

/// The scenario in a world without obstacles and walkers near the start.
[[nodiscard]] Scenario without_obstacles(Scenario scenario);

/// A scenario of several goals with the one selected by the seed, modulo their number. Unless the
/// scenario sets a route, the driver gets the widest path there. Throws like in_its_world().
[[nodiscard]] Scenario with_its_goal(Scenario scenario);

}  // namespace tandem
