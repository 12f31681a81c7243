// SPDX-License-Identifier: Apache-2.0
#include "map/map_file.hpp"

#include <stdexcept>

#include "config/yaml_reader.hpp"
#include "map/extrude.hpp"
#include "map/image_map.hpp"
#include "map/map_description.hpp"
#include "map/octomap_file.hpp"

namespace tandem {
namespace {

std::unique_ptr<octomap::OcTree> load_walls(const std::filesystem::path& file, double height) {
  const OccupancyPlane plane = load_image_map(file);
  try {
    return extrude(to_grid(plane), height);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace

bool is_yaml(const std::filesystem::path& file) {
  return file.extension() == ".yaml" || file.extension() == ".yml";
}

std::unique_ptr<octomap::OcTree> load_map(const std::filesystem::path& file, double wall_height) {
  if (!is_yaml(file)) return load_octomap(file);
  if (is_image_map(YamlReader{file.string()}.load())) return load_walls(file, wall_height);
  return build_octomap(load_map_description(file));
}

}  // namespace tandem
