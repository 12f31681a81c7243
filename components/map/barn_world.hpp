// SPDX-License-Identifier: Apache-2.0
// Reads one world of the BARN data set as a map description.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "tandem/map/map_description.hpp"

namespace tandem {

/// The worlds of BARN (Perille et al., "Benchmarking Metric Ground Navigation", 2020) in one JSON
/// file: `{"meta": {"cylinder_radius_m": r, "start": {x, y}, "goal": {x, y}}, "worlds": {"17":
/// {"cylinders": [[x, y], …], "reference_path": [[x, y], …]}, …}}`. The bounds enclose every
/// cylinder and 1 m around start and goal. Throws std::runtime_error: one line with the file and
/// the error.
[[nodiscard]] MapDescription load_barn_world(const std::filesystem::path& file, int number);

/// The numbers of the worlds in the file, in ascending order. Throws as load_barn_world.
[[nodiscard]] std::vector<int> barn_world_numbers(const std::filesystem::path& file);

/// The number of the world with index `seed` in the file, modulo the number of worlds. Throws as
/// load_barn_world.
[[nodiscard]] int barn_world_number(const std::filesystem::path& file, unsigned seed);

/// Length of BARN's reference path [m]: from the start along the world's `reference_path` to the
/// goal; nullopt if the file has none. Throws as load_barn_world.
[[nodiscard]] std::optional<double> barn_way_length(const std::filesystem::path& file, int number);

}  // namespace tandem
