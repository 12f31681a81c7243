// SPDX-License-Identifier: Apache-2.0
// In: a scenario whose map is a family of worlds. Out: the scenario in one of them.
#pragma once

#include <string>

#include "bringup/scenario.hpp"

namespace tandem {

/// Whether `map` names no OctoMap but many worlds: the word `clutter`, or a JSON file of BARN
/// worlds.
[[nodiscard]] bool is_family(const std::string& map);

/// The scenario in the world that belongs to its seed: clutter of that seed, or the seed-th world
/// of the file, counted round. Writes the world's OctoMap into the system's folder for temporary
/// files and, unless the scenario gives a route, has the driver know the widest way from the start
/// to the middle of the goal. Throws std::runtime_error or std::invalid_argument: one line that
/// says why.
[[nodiscard]] Scenario in_its_world(Scenario scenario);

}  // namespace tandem
