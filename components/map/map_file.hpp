// SPDX-License-Identifier: Apache-2.0
// Reads a map from a file of any kind that Tandem knows.
#pragma once

#include <octomap/OcTree.h>

#include <filesystem>
#include <memory>

namespace tandem {

/// How high the walls of a map without heights are [m]: higher than robots.
inline constexpr double kWallHeight = 2.0;

/// An OctoMap (.bt, .ot), or in YAML a map of Nav2's map_server, whose walls become `wall_height`
/// [m] high, or a description. Throws std::invalid_argument for what is wrong in the YAML and
/// std::runtime_error for a tree or an image, each one line that names the file.
[[nodiscard]] std::unique_ptr<octomap::OcTree> load_map(const std::filesystem::path& file,
                                                        double wall_height = kWallHeight);

/// Whether the file is YAML by its name.
[[nodiscard]] bool is_yaml(const std::filesystem::path& file);

}  // namespace tandem
