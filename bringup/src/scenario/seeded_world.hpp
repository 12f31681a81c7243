// SPDX-License-Identifier: Apache-2.0
// In: a scenario of many worlds or many goals. Out: the scenario in one of them, to one of them.
#pragma once

#include <string>

#include "bringup/scenario/scenario.hpp"

namespace tandem {

/// Whether `map` names no OctoMap but many worlds: the word `clutter`, or a JSON file of BARN
/// worlds.
[[nodiscard]] bool is_family(const std::string& map);

/// Throws std::invalid_argument if the map is a file of worlds and has none for the seed, which is
/// a world's place in the file, from 1 on; std::runtime_error if it is no such file.
void check_seed(const std::string& map, unsigned seed);

/// The scenario in the world that belongs to its seed: clutter of that seed, or the seed-th world
/// of the file. Writes the world's OctoMap into the system's folder for temporary files, under a
/// name that belongs to its content, and, unless the scenario gives a route, has the driver know
/// the widest way from the start to the middle of the goal. Throws std::runtime_error or
/// std::invalid_argument: one line that says why.
[[nodiscard]] Scenario in_its_world(Scenario scenario);

/// A scenario of several goals with the one whose turn it is by the seed, counted round; the driver
/// knows the widest way there unless the scenario gives a route. Throws as in_its_world.
[[nodiscard]] Scenario with_its_goal(Scenario scenario);

}  // namespace tandem
