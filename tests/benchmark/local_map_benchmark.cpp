// SPDX-License-Identifier: Apache-2.0
// Prints the cost of each step from a scan to the shapes of its obstacles, along drives without a
// map.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>

#include "obstacle_extractor/worlds.hpp"
#include "tandem/map/overlay.hpp"
#include "tandem/obstacle_extractor/extractor.hpp"
#include "tandem/octomap_builder/local_map.hpp"

namespace tandem {
namespace {

constexpr int kBeams = 720;
constexpr double kRange = 10.0;  // of the scanner [m]
constexpr double kPeriod = 0.1;  // [s]
constexpr double kNoise = 0.01;  // [m] standard deviation of a range

class Stopwatch {
 public:
  void lap(const std::string& what) {
    const auto now = std::chrono::steady_clock::now();
    laps_[what].push_back(std::chrono::duration<double, std::milli>(now - last_).count());
    last_ = std::chrono::steady_clock::now();
  }
  void add(const std::string& what, double value) { laps_[what].push_back(value); }
  void start() { last_ = std::chrono::steady_clock::now(); }
  void print() {
    for (auto& [what, values] : laps_) {
      std::sort(values.begin(), values.end());
      const auto at = [&sorted = values](double share) {
        return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
      };
      std::printf("%-28s p50 %8.2f  p99 %8.2f  max %8.2f\n", what.c_str(), at(0.5), at(0.99),
                  at(1.0));
    }
  }

 private:
  std::chrono::steady_clock::time_point last_;
  std::map<std::string, std::vector<double>> laps_;
};

RangeReturns look(const StaticMap& world, const Pose2& X, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, kNoise);
  std::vector<float> ranges;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kBeams;
    const double d = world.cast_ray(X.position(), X.theta + angle, kRange);
    ranges.push_back(d < kRange ? static_cast<float>(d + noise(random))
                                : std::numeric_limits<float>::infinity());
  }
  return range_returns_of(RangeScan{.angle_min = 0.0,
                                    .angle_increment = 2.0 * std::numbers::pi / kBeams,
                                    .range_min = 0.1,
                                    .range_max = kRange,
                                    .ranges = ranges});
}

void drive(const char* name, const StaticMap& world, const std::vector<Eigen::Vector2d>& way,
           double speed) {
  LocalMap local({.decay = 20.0});
  std::optional<Extractor> extractor;
  Stopwatch clock;
  std::mt19937 random{1};
  const ExtractorParams params;
  double t = 0.0;
  for (std::size_t leg = 1; leg < way.size(); ++leg) {
    const Eigen::Vector2d along = way[leg] - way[leg - 1];
    for (double s = 0.0; s < along.norm(); s += speed * kPeriod) {
      const Eigen::Vector2d p = way[leg - 1] + s * along.normalized();
      const Pose2 X{p.x(), p.y(), std::atan2(along.y(), along.x())};
      const RangeReturns echoes = look(world, X, random);
      const Eigen::Isometry3d X_MS = Eigen::Translation3d(X.x, X.y, 0.3) *
                                     Eigen::AngleAxisd(X.theta, Eigen::Vector3d::UnitZ());
      clock.start();
      const Look look{echoes, X_MS};
      if (!local.insert({&look, 1}, t += kPeriod)) return;
      clock.lap("1 insert [ms]");
      const auto bytes = encode_octomap(local.tree());
      clock.lap("2 encode [ms]");
      clock.add("0 message [kB]", 1e-3 * static_cast<double>(bytes.size()));
      const Grid seen = slice_octomap({}, bytes, {}, true);
      clock.lap("3 slice [ms]");
      const auto map = std::make_shared<const StaticMap>(overlay({}, seen, p, 10.0));
      clock.lap("4 overlay and field [ms]");
      if (extractor)
        extractor->update(map);
      else
        extractor.emplace(map, params);
      clock.lap("5 places [ms]");
      clock.add("8 shapes", static_cast<double>(extractor->shapes_near(p, 6.0).size()));
      clock.lap("6 changed tiles [ms]");
      int refreshed = 0;
      while (refreshed < 2 && extractor->refresh_near(p, 6.0, 5)) ++refreshed;
      if (refreshed > 0) clock.lap("7 two tiles refreshed [ms]");
    }
  }
  std::printf("%s\n", name);
  clock.print();
}

// A depth camera of 640 × 480 points, 87° × 58°, above a floor and 3 m from a wall.
void look_by_camera() {
  RangeReturns echoes;
  for (int row = 0; row < 480; ++row)
    for (int column = 0; column < 640; ++column) {
      const Eigen::Vector3d direction{1.0, (column - 320) / 337.0, (row - 240) / 433.0};
      const double to_floor = direction.z() < 0.0 ? -0.6 / direction.z() : 100.0;
      echoes.p_SQ.push_back(std::min(3.0, to_floor) * direction);
    }
  LocalMap local({});
  Stopwatch clock;
  const Look look{echoes, Eigen::Isometry3d{Eigen::Translation3d(0.0, 0.0, 0.6)}};
  for (int i = 0; i < 30; ++i) {
    clock.start();
    if (!local.insert({&look, 1}, 0.1 * i)) return;
    clock.lap("1 insert [ms]");
    const auto bytes = encode_octomap(local.tree());
    clock.lap("2 encode [ms]");
    clock.add("0 message [kB]", 1e-3 * static_cast<double>(bytes.size()));
    (void)slice_octomap({}, bytes, {}, true);
    clock.lap("3 slice [ms]");
  }
  std::printf("depth camera, 307200 points\n");
  clock.print();
}

}  // namespace
}  // namespace tandem

int main() {
  using namespace tandem;
  drive("corridor", *test::load_world(test::project_map("corridor")), {{1.0, 0.0}, {13.0, 0.0}},
        0.8);
  drive("forest", *test::load_world(test::project_map("forest")),
        {{-4.0, -4.0}, {-1.5, -3.0}, {2.0, -2.0}, {1.0, 0.5}}, 0.8);
  look_by_camera();
}
