// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/map_file.hpp"

#include <stdexcept>

#include "tandem/config/yaml_document.hpp"
#include "tandem/map/extrude.hpp"
#include "tandem/map/image_map.hpp"
#include "tandem/map/map_description.hpp"
#include "tandem/map/octomap_file.hpp"

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

std::string file_key(const std::filesystem::path& file) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(file, error).time_since_epoch().count();
  return file.string() + '@' + std::to_string(error ? 0 : written) + ' ';
}

bool is_yaml(const std::filesystem::path& file) {
  return file.extension() == ".yaml" || file.extension() == ".yml";
}

std::unique_ptr<octomap::OcTree> load_map(const std::filesystem::path& file, double wall_height) {
  if (!is_yaml(file)) return load_octomap(file);
  if (is_image_map(load_document(file.string()))) return load_walls(file, wall_height);
  return build_octomap(load_map_description(file));
}

}  // namespace tandem
