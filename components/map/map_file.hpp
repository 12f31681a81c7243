// SPDX-License-Identifier: Apache-2.0
// Reads a map from a file of any supported kind.
#pragma once

#include <octomap/OcTree.h>

#include <filesystem>
#include <memory>
#include <string>

namespace tandem {

/// Wall height for maps without heights [m]; taller than robots.
inline constexpr double kWallHeight = 2.0;

/// Reads an OctoMap (.bt, .ot) or a YAML file: a map of Nav2's map_server, whose walls become
/// `wall_height` [m] high, or a map description. Throws std::invalid_argument for errors in the
/// YAML and std::runtime_error for errors in a tree or an image, each one line that names the file.
[[nodiscard]] std::unique_ptr<octomap::OcTree> load_map(const std::filesystem::path& file,
                                                        double wall_height = kWallHeight);

/// Names the file and its state by path and time of the last change, for a cache of what was read
/// from it. An image or tree that a YAML file names is not part of it.
[[nodiscard]] std::string file_key(const std::filesystem::path& file);

/// Whether the file's extension is that of YAML.
[[nodiscard]] bool is_yaml(const std::filesystem::path& file);

}  // namespace tandem
