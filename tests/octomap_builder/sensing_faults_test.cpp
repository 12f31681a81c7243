// SPDX-License-Identifier: Apache-2.0
// A robot that knows what stands in its way from its scanner alone, and a scanner that fails: the
// cores that take scans to the filter, in one loop with the simulated base.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "diff_drive_sim/diff_drive_sim.hpp"
#include "map/overlay.hpp"
#include "map/slice.hpp"
#include "octomap_builder/local_map.hpp"
#include "octomap_builder/mounting.hpp"
#include "octomap_builder/scan_reader.hpp"
#include "octomap_builder/sensor_watch.hpp"
#include "safety_filter/safety_filter.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

constexpr int kBeams = 360;
constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kInvalid = std::numeric_limits<float>::quiet_NaN();
constexpr double kScanRange = 10.0;
constexpr double kTick = 0.05, kScanPeriod = 0.1, kDuration = 15.0;  // [s]
constexpr double kReach = 4.0;                                       // [m] of the map

using Random = std::mt19937;
double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// A room of 6 m with some poles, none where the robot starts.
std::shared_ptr<const StaticMap> room_with_poles(Random& random) {
  Grid grid{0.05, {-4.0, -4.0}, 160, 160, std::vector<Cell>(25600, Cell::kFree)};
  std::vector<Eigen::Vector2d> poles;
  for (int i = 0; i < 4; ++i) {
    const double angle = between(random, -3.1, 3.1), d = between(random, 1.3, 2.8);
    poles.emplace_back(d * std::cos(angle), d * std::sin(angle));
  }
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix) {
      const Eigen::Vector2d p = grid.center(ix, iy);
      bool occupied = p.cwiseAbs().maxCoeff() > 3.0;
      for (const auto& pole : poles) occupied = occupied || (p - pole).norm() < 0.12;
      if (occupied) grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
    }
  return std::make_shared<const StaticMap>(std::move(grid));
}

struct Scan {
  std::vector<float> ranges;
  double range_max = kScanRange;
};

// What becomes of a scan, for a scanner that fails in this way.
using Fault = std::function<void(Scan&, Random&)>;

Fault all_beams(float value) {
  return [value](Scan& scan, Random&) { scan.ranges.assign(kBeams, value); };
}
void lose_half(Scan& scan, Random& random) {
  for (float& range : scan.ranges)
    if (random() % 2 == 0) range = kInvalid;
}
void lose_a_side(Scan& scan, Random&) {
  std::fill(scan.ranges.begin() + kBeams / 4, scan.ranges.begin() + kBeams * 3 / 4, kInvalid);
}
void farthest_as_range_max(Scan& scan, Random&) {
  scan.range_max = *std::max_element(scan.ranges.begin(), scan.ranges.end());
}
void see_posts(Scan& scan, Random&) {
  for (int i = 0; i < kBeams; i += 30) scan.ranges[static_cast<std::size_t>(i)] = 0.25F;
}
Fault frozen() {
  return [first = std::optional<Scan>{}](Scan& scan, Random&) mutable {
    if (!first) first = scan;
    scan = *first;
  };
}

class Drive {
 public:
  Drive(unsigned seed, bool fails_from_start, Fault fault, const ScanReaderParams& scan)
      : random_{seed},
        fault_{std::move(fault)},
        fault_begins_{fails_from_start ? 0.0 : between(random_, 1.0, 6.0)},
        map_{room_with_poles(random_)},
        sim_{{}, robot_, map_, seed},
        reader_{scan, local_params_.min_range} {
    sim_.reset({0.0, 0.0, between(random_, -3.1, 3.1)}, seed);
  }

  void run() {
    Twist2 wish;
    for (int n = 1; n * kTick < kDuration; ++n) {
      const double t = n * kTick;
      sim_.advance_to(t);
      const OdometryReport report = sim_.odometry();
      const RobotState robot{compose(report.X_MW, report.X_WB), report.twist, t};
      if (n % std::lround(kScanPeriod / kTick) == 0) look(robot, report.X_WB, t);
      if (n % 30 == 1) wish = {between(random_, -0.4, 0.8), between(random_, -1.0, 1.0)};
      if (n % 60 < 30) wish.v = 0.8;  // pushes ahead half of the time
      filter_.on_command(wish, t);
      const Filtered out = filter_.update(robot, t);
      travelled_ += kTick * std::abs(sim_.state().twist.v);
      sim_.command(out.twist, t);
    }
  }

  [[nodiscard]] unsigned contacts() const { return sim_.contacts().count; }
  [[nodiscard]] double travelled() const { return travelled_; }
  [[nodiscard]] std::string reason() { return watch_.reason(kDuration); }

 private:
  void look(const RobotState& robot, const Pose2& X_WB, double t) {
    Scan scan;
    for (int i = 0; i < kBeams; ++i) {
      const double range = sim_.beam(sim_.state().X_MB, i, kBeams, kScanRange);
      scan.ranges.push_back(range < kScanRange ? static_cast<float>(range) : kNothing);
    }
    if (t > fault_begins_) fault_(scan, random_);
    take(scan, robot.X_MB, X_WB, t);
    if (!looked_) return;
    const auto grid = overlay(Grid{}, slice(local_.tree(), {}), robot.X_MB.position(), kReach);
    const bool sees = watch_.reason(t).empty();
    filter_.on_map(sees ? std::make_shared<const StaticMap>(grid) : nullptr);
  }

  // As the octomap_builder does.
  void take(const Scan& scan, const Pose2& X_MB, const Pose2& X_WB, double t) {
    const RangeScan ranges{.angle_min = -std::numbers::pi,
                           .angle_increment = 2.0 * std::numbers::pi / kBeams,
                           .range_min = 0.0,
                           .range_max = scan.range_max,
                           .ranges = scan.ranges};
    const ScanReading reading = reader_.read(ranges, X_BS_, body_);
    if (!reading.error.empty()) return watch_.on_trouble(reading.error, t);
    const LookUse use =
        watch_.judge({reading.seen, X_BS_, X_WB, reading.valid_share}, reading.composition, t);
    const Look look{reading.seen, in_space(X_MB) * X_BS_};
    if (use == LookUse::kNone || (use == LookUse::kTake && !local_.insert({&look, 1}, t))) return;
    watch_.on_taken(t);
    looked_ = true;
  }

  Random random_;
  Fault fault_;
  double fault_begins_;  // [s]
  RobotParams robot_;
  std::shared_ptr<const StaticMap> map_;
  DiffDriveSim sim_;
  Eigen::Isometry3d X_BS_{Eigen::Translation3d(0.0, 0.0, 0.3)};
  LocalMapParams local_params_;
  LocalMap local_{local_params_};
  OwnBody body_{footprint_of(robot_)};
  ScanReader reader_;
  SensorWatch watch_{"scan", {}, local_params_.resolution};
  SafetyFilter filter_{{}, robot_};
  bool looked_ = false;     // at least once
  double travelled_ = 0.0;  // [m]
};

struct Case {
  const char* name;
  std::function<Fault()> fault;
  const char* reason;  // at the end; empty: it drives on
  ScanReaderParams scan = {};
  bool always_sees_first = false;  // else it fails from the start in every second drive
};

class SensingFaults : public testing::TestWithParam<Case> {};

TEST_P(SensingFaults, TouchNothing) {
  const Case& c = GetParam();
  double least = 1e9;
  for (unsigned seed = 1; seed <= samples(6, 2); ++seed) {
    Drive drive{seed, !c.always_sees_first && seed % 2 == 1, c.fault(), c.scan};
    drive.run();
    EXPECT_EQ(drive.contacts(), 0u) << seed;
    least = std::min(least, drive.travelled());
    const bool is_named = *c.reason == '\0' ? drive.reason().empty()
                                            : drive.reason().find(c.reason) != std::string::npos;
    EXPECT_TRUE(is_named) << seed << ": " << drive.reason();
  }
  if (*c.reason == '\0') {
    EXPECT_GT(least, 2.0);  // [m]
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, SensingFaults,
    testing::Values(Case{"None", [] { return [](Scan&, Random&) {}; }, ""},
                    Case{"Zeros", [] { return all_beams(0.0F); }, "gives no valid range"},
                    Case{"NaN", [] { return all_beams(kInvalid); }, "gives no valid range"},
                    Case{"NoBeams", [] { return [](Scan& scan, Random&) { scan.ranges.clear(); }; },
                         "gives no valid range"},
                    Case{"Covered", [] { return all_beams(0.2F); }, "gives no valid range"},
                    Case{"Frozen", frozen, "frozen"},
                    Case{"HalfTheBeamsLost", [] { return Fault{lose_half}; }, ""},
                    // Ground that was never seen counts as free in this loop.
                    Case{"OneSideLost", [] { return Fault{lose_a_side}; }, "", {}, true},
                    Case{"OwnBody", [] { return Fault{see_posts}; }, ""},
                    Case{"FarthestAsRangeMax", [] { return Fault{farthest_as_range_max}; }, ""},
                    Case{"FarthestAsRangeMaxNamed",
                         [] { return Fault{farthest_as_range_max}; },
                         "varies",
                         {.no_return = {"inf", "range_max"}}}),
    [](const auto& tested) { return std::string{tested.param.name}; });

}  // namespace
}  // namespace tandem::test
