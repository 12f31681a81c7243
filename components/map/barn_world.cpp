// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/barn_world.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "tandem/config/json_text.hpp"

namespace tandem {
namespace {

using Json = nlohmann::json;

constexpr double kHeight = 1.0;       // [m] of a cylinder
constexpr double kAround = 1.0;       // [m] free space around start and goal
constexpr double kLargest = 100.0;    // [m] largest side of a world; BARN's are 5 m by 10 m
constexpr double kResolution = 0.05;  // [m]

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

Json parse(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!std::filesystem::is_regular_file(file) || !stream)
    fail(file, "no such file, or it is not readable; give the path of a BARN world file");
  Json root = parse_json_or_null<Json>(stream);
  if (!root.is_object() || !root.contains("meta") || !root.contains("worlds") ||
      !root["meta"].is_object() || !root["worlds"].is_object())
    fail(file, "not a BARN world file: expected JSON with 'meta' and 'worlds'");
  return root;
}

// A study reads the same file for each of its drives, and parsing takes a tenth of a short drive.
std::shared_ptr<const Json> load(const std::filesystem::path& file) {
  struct Parsed {
    std::filesystem::path file;
    std::filesystem::file_time_type written;
    std::shared_ptr<const Json> root;
  };
  static std::mutex mutex;
  static Parsed last;
  std::error_code error;
  const auto written = std::filesystem::last_write_time(file, error);
  const std::lock_guard lock{mutex};
  if (error || !last.root || last.file != file || last.written != written)
    last = {file, written, std::make_shared<const Json>(parse(file))};
  return last.root;
}

double coordinate(const Json& value) {
  const double metres = value.get<double>();
  if (std::abs(metres) <= 1e3) return metres;
  throw std::runtime_error("a coordinate beyond 1000 m");
}

void hold(MapDescription& map, double x, double y, double around) {
  map.low = map.low.cwiseMin(Eigen::Vector3d{x - around, y - around, 0.0});
  map.high = map.high.cwiseMax(Eigen::Vector3d{x + around, y + around, kHeight});
}

MapDescription world(const Json& meta, const Json& cylinders) {
  MapDescription map;
  map.resolution = kResolution;
  map.low.setConstant(1e6);
  map.high.setConstant(-1e6);
  const double radius = meta.at("cylinder_radius_m").get<double>();
  if (!(radius >= kResolution && radius <= 10.0)) throw std::runtime_error("cylinder_radius_m");
  for (const char* place : {"start", "goal"})
    hold(map, coordinate(meta.at(place).at("x")), coordinate(meta.at(place).at("y")), kAround);
  for (const Json& center : cylinders) {
    Solid solid;
    solid.shape = Solid::Shape::kDisc;
    solid.p_MC = {coordinate(center.at(0)), coordinate(center.at(1))};
    solid.size.setConstant(2.0 * radius);
    solid.z_high = kHeight;
    hold(map, solid.p_MC.x(), solid.p_MC.y(), radius);
    map.solids.push_back(solid);
  }
  if (map.solids.empty()) throw std::runtime_error("no cylinders");
  if ((map.high - map.low).head<2>().prod() > kLargest * kLargest ||
      static_cast<double>(map.solids.size()) * radius * radius > kLargest * kLargest)
    throw std::runtime_error("larger than a map of 100 m by 100 m");
  return map;
}

// Length of the path from start to goal [m]; nullopt without a reference path.
std::optional<double> way_length(const Json& meta, const Json& entry) {
  const auto way = entry.find("reference_path");
  if (way == entry.end() || way->empty()) return std::nullopt;
  const auto place = [](const Json& x, const Json& y) {
    return Eigen::Vector2d{coordinate(x), coordinate(y)};
  };
  const auto named = [&](const char* name) {
    return place(meta.at(name).at("x"), meta.at(name).at("y"));
  };
  Eigen::Vector2d at = named("start");
  double length = 0.0;
  const auto go_to = [&](const Eigen::Vector2d& next) {
    length += (next - at).norm();
    at = next;
  };
  for (const Json& point : *way) go_to(place(point.at(0), point.at(1)));
  go_to(named("goal"));
  return length;
}

// The existing numbers next to `number`; the numbering has gaps.
std::string nearest_to(int number, const std::vector<int>& numbers) {
  const auto above = std::upper_bound(numbers.begin(), numbers.end(), number);
  std::string text;
  if (above != numbers.begin()) text = std::to_string(*(above - 1));
  if (above != numbers.end()) text += (text.empty() ? "" : " and ") + std::to_string(*above);
  return text.empty() ? "" : ", next to it " + text;
}

// Applies `read` to the file's meta data and the world of that number.
template <class Read>
auto of_world(const std::filesystem::path& file, int number, const Read& read) {
  const auto root = load(file);
  const Json& worlds = root->at("worlds");
  const auto entry = worlds.find(std::to_string(number));
  if (entry == worlds.end()) {
    const auto numbers = barn_world_numbers(file);
    fail(file, "no world " + std::to_string(number) + "; it has " + std::to_string(numbers.size()) +
                   nearest_to(number, numbers));
  }
  try {
    return read(root->at("meta"), *entry);
  } catch (const std::exception& error) {
    fail(file, "world " + std::to_string(number) + ": " + error.what());
  }
}

}  // namespace

MapDescription load_barn_world(const std::filesystem::path& file, int number) {
  return of_world(file, number, [](const Json& meta, const Json& entry) {
    return world(meta, entry.at("cylinders"));
  });
}

std::optional<double> barn_way_length(const std::filesystem::path& file, int number) {
  return of_world(file, number, way_length);
}

int barn_world_number(const std::filesystem::path& file, unsigned seed) {
  const auto numbers = barn_world_numbers(file);
  if (numbers.empty()) fail(file, "it contains no world");
  return numbers[(seed + numbers.size() - 1) % numbers.size()];
}

std::vector<int> barn_world_numbers(const std::filesystem::path& file) {
  std::vector<int> numbers;
  const auto root = load(file);
  for (const auto& [name, world] : root->at("worlds").items()) {
    if (name.empty() || name.size() > 6 || name.find_first_not_of("0123456789") != name.npos)
      fail(file, "world '" + name + "' has no number");
    numbers.push_back(std::stoi(name));
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace tandem
