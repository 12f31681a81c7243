// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/image_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
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

Mode mode_of(const std::optional<YamlReader>& value) {
  const std::string name = !value ? "trinary" : value->is_scalar() ? value->as<std::string>() : "";
  if (name == "trinary") return Mode::kTrinary;
  if (name == "scale") return Mode::kScale;
  if (name == "raw") return Mode::kRaw;
  value->fail("mode must be trinary, scale or raw");
}

// Accepts 0 and 1, as map_server does, or false and true.
bool negate_of(const std::optional<YamlReader>& value) {
  if (!value) return false;
  const std::string text = value->is_scalar() ? value->as<std::string>() : "";
  return text == "0" || text == "1" ? text == "1" : value->as<bool>();
}

Legend legend_of(YamlReader& root) {
  const YamlReader free_thresh = root.required("free_thresh");
  Legend legend{mode_of(root.optional("mode")), negate_of(root.optional("negate")),
                free_thresh.number(0.0, 1.0), root.required("occupied_thresh").number(0.0, 1.0)};
  if (!(legend.free_thresh < legend.occupied_thresh))
    free_thresh.fail("free_thresh must be below occupied_thresh");
  return legend;
}

bool is_file_name(const YamlReader& value) {
  const std::string name = value.is_scalar() ? value.as<std::string>() : "\n";
  return std::none_of(name.begin(), name.end(),
                      [](char c) { return static_cast<unsigned char>(c) < ' '; });
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

// Keys that this reader does not know are other map servers'.
OccupancyPlane load_image_map(const std::filesystem::path& file) {
  YamlReader root = YamlReader::load(file.string());
  const YamlReader image_name = root.required("image");
  if (!is_file_name(image_name)) image_name.fail("expected the name of an image");
  const Eigen::Vector3d origin = root.required("origin").vector<3>();
  const Legend legend = legend_of(root);
  OccupancyPlane plane;
  plane.X_MO = {origin.x(), origin.y(), origin.z()};
  plane.resolution = root.required("resolution").number(1e-3, 10.0);
  const GrayImage image = read_gray_image(file.parent_path() / image_name.as<std::string>());
  plane.width = image.width;
  plane.height = image.height;
  plane.percent = percents_of(image, legend);
  if (const std::string error = error_of(plane); !error.empty())
    root.fail(error + "; are the thresholds, `negate` and `mode` those of its image?");
  return plane;
}

}  // namespace tandem
