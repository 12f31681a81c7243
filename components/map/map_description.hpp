// SPDX-License-Identifier: Apache-2.0
// Reads a map written in YAML (maps/*.yaml) and builds its OctoMap.
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tandem {

/// Upright solid between two heights [m]: a rectangle rotated by `angle`, or a disc.
struct Solid {
  /// Its outline seen from above.
  enum class Shape { kRectangle, kDisc };

  Shape shape = Shape::kRectangle;   ///< rectangle or disc
  Eigen::Vector2d p_MC{0.0, 0.0};    ///< centre [m]
  Eigen::Vector2d size{0.0, 0.0};    ///< length and width; for a disc its diameter in both [m]
  double angle = 0.0;                ///< heading of the length [rad]
  double z_low = 0.0, z_high = 0.0;  ///< [m] above the floor
};

/// A world of solids. Inside the bounds everything else is free, or unknown without `free_space`.
struct MapDescription {
  double resolution = 0.05;                     ///< side of a voxel [m]
  Eigen::Vector3d low{0, 0, 0}, high{0, 0, 0};  ///< bounds [m]
  bool free_space = true;                       ///< false: space that is not solid stays unknown
  bool floor = false;                           ///< one layer of voxels below z = 0
  std::vector<Solid> solids;                    ///< in M
};

/// Reads a description,
///
///     resolution: 0.05                        # [m]
///     bounds: {low: [x, y, z], high: [x, y, z]}
///     free_space: true                        # default
///     floor: false                            # default
///     walls:     [{points: [[x, y], …], thickness: t, height: h, closed: false}, …]
///     boxes:     [{center: [x, y], size: [along, across], angle: radians, height: h}, …]
///     cylinders: [{center: [x, y], diameter: d, height: h}, …]
///
/// where `z: [low, high]` may replace `height: h` (z from 0 to h). A wall follows its points; its
/// free ends are flat and end at the point. Throws std::invalid_argument naming `name`, the line
/// and the error; an unknown key is an error.
[[nodiscard]] MapDescription parse_map_description(const std::string& text,
                                                   const std::string& name);

/// parse_map_description() for a file.
[[nodiscard]] MapDescription load_map_description(const std::filesystem::path& file);

/// A voxel is occupied if its centre lies in a solid. Equal descriptions give equal trees.
[[nodiscard]] std::unique_ptr<octomap::OcTree> build_octomap(const MapDescription& description);

}  // namespace tandem
