// SPDX-License-Identifier: Apache-2.0
// Reads the maps of Nav2's map_server: a YAML file that names an image.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>

#include "tandem/map/occupancy_plane.hpp"

namespace tandem {

/// Whether `root`, the root of a YAML file, describes such a map.
[[nodiscard]] bool is_image_map(const YAML::Node& root);

/// Reads such a map as map_server does:
///
///     image: room.pgm                  # or .png; beside the YAML file
///     resolution: 0.05                 # [m] of a pixel
///     origin: [x, y, yaw]              # [m, m, rad] of the lower left pixel's corner
///     occupied_thresh: 0.65
///     free_thresh: 0.25
///     negate: 0                        # default; 1: white is occupied
///     mode: trinary                    # default; scale, raw
///
/// Keys unknown to map_server are ignored, as it does. Throws std::invalid_argument for errors in
/// the YAML and std::runtime_error for errors in the image, each one line that names the file.
[[nodiscard]] OccupancyPlane load_image_map(const std::filesystem::path& file);

}  // namespace tandem
