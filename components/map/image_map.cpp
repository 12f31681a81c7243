// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/image_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string>

#include "tandem/config/yaml_reader.hpp"
#include "tandem/map/gray_image.hpp"

namespace tandem {
namespace {

constexpr std::int8_t kUnknown = -1, kFree = 0, kOccupied = 100;  // [%]

enum class Mode { kTrinary, kScale, kRaw };

// How pixels map to occupancy.
struct Legend {
  Mode mode = Mode::kTrinary;
  bool negate = false;
  double free_thresh = 0.25, occupied_thresh = 0.65;
};

Mode mode_of(const YamlReader& reader, const YAML::Node& node) {
  const std::string name = !node ? "trinary" : node.IsScalar() ? node.Scalar() : "";
  if (name == "trinary") return Mode::kTrinary;
  if (name == "scale") return Mode::kScale;
  if (name == "raw") return Mode::kRaw;
  reader.fail(node, "mode must be trinary, scale or raw");
}

// Accepts 0 and 1, as map_server does, or false and true.
bool negate_of(const YamlReader& reader, const YAML::Node& root) {
  const YAML::Node node = root["negate"];
  if (node && node.IsScalar() && (node.Scalar() == "0" || node.Scalar() == "1"))
    return node.Scalar() == "1";
  return reader.flag(root, "negate", false);
}

Legend legend_of(const YamlReader& reader, const YAML::Node& root) {
  Legend legend{mode_of(reader, root["mode"]), negate_of(reader, root),
                reader.number(reader.required(root, "free_thresh"), 0.0, 1.0),
                reader.number(reader.required(root, "occupied_thresh"), 0.0, 1.0)};
  if (!(legend.free_thresh < legend.occupied_thresh))
    reader.fail(root["free_thresh"], "free_thresh must be below occupied_thresh");
  return legend;
}

bool is_file_name(const YAML::Node& node) {
  return node.IsScalar() && std::none_of(node.Scalar().begin(), node.Scalar().end(), [](char c) {
           return static_cast<unsigned char>(c) < ' ';
         });
}

double share(std::uint32_t value) { return value / static_cast<double>(GrayImage::kWhite); }

std::int8_t trinary(double occupancy, const Legend& legend) {
  if (occupancy > legend.occupied_thresh) return kOccupied;
  return occupancy < legend.free_thresh ? kFree : kUnknown;
}

std::int8_t scale(double occupancy, const Legend& legend) {
  const std::int8_t whole = trinary(occupancy, legend);
  if (whole != kUnknown) return whole;
  return static_cast<std::int8_t>(std::lround(100.0 * (occupancy - legend.free_thresh) /
                                              (legend.occupied_thresh - legend.free_thresh)));
}

std::int8_t raw(double shade) {
  const long percent = std::lround(255.0 * shade);
  return percent <= kOccupied ? static_cast<std::int8_t>(percent) : kUnknown;
}

// As map_server, which averages the opacity with the colours in trinary mode, and treats pixels
// that are not opaque as unknown in scale mode.
std::int8_t percent_of(const GrayImage& image, std::size_t i, const Legend& legend) {
  constexpr std::uint32_t kColors = 3;
  std::uint32_t shade = image.shade[i];
  const bool has_opacity = !image.opacity.empty();
  if (legend.mode == Mode::kRaw) return raw(share(shade));
  if (legend.mode == Mode::kScale && has_opacity && image.opacity[i] != GrayImage::kWhite)
    return kUnknown;
  const bool averages = legend.mode == Mode::kTrinary && has_opacity;
  const double mean =
      averages ? share(kColors * shade + image.opacity[i]) / (kColors + 1) : share(shade);
  const double occupancy = legend.negate ? mean : 1.0 - mean;
  return legend.mode == Mode::kScale ? scale(occupancy, legend) : trinary(occupancy, legend);
}

// Rows in ascending y; the lowest row is the image's last.
std::vector<std::int8_t> percents_of(const GrayImage& image, const Legend& legend) {
  const auto width = static_cast<std::size_t>(image.width);
  std::vector<std::int8_t> percents;
  percents.reserve(image.shade.size());
  for (std::size_t row = image.shade.size(); row > 0; row -= width)
    for (std::size_t i = row - width; i < row; ++i)
      percents.push_back(percent_of(image, i, legend));
  return percents;
}

}  // namespace

bool is_image_map(const YAML::Node& root) { return root.IsMap() && root["image"]; }

OccupancyPlane load_image_map(const std::filesystem::path& file) {
  const YamlReader reader{file.string()};
  const YAML::Node root = reader.load();
  reader.each_once(root);
  const YAML::Node image_name = reader.required(root, "image");
  if (!is_file_name(image_name)) reader.fail(image_name, "expected the file name of an image");
  const Eigen::Vector3d origin = reader.vector<3>(reader.required(root, "origin"));
  const Legend legend = legend_of(reader, root);
  OccupancyPlane plane;
  plane.X_MO = {origin.x(), origin.y(), origin.z()};
  plane.resolution = reader.number(reader.required(root, "resolution"), 1e-3, 10.0);
  const GrayImage image = read_gray_image(file.parent_path() / image_name.Scalar());
  plane.width = image.width;
  plane.height = image.height;
  plane.percent = percents_of(image, legend);
  if (const std::string error = error_of(plane); !error.empty())
    reader.fail(root, error + "; do the thresholds, `negate` and `mode` match the image?");
  return plane;
}

}  // namespace tandem
