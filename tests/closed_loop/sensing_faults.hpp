// SPDX-License-Identifier: Apache-2.0
// Drives a robot that knows obstacles only from its scanner, while the scanner or the odometry
// fails. Runs the cores from scans to the filter in one loop with the simulated base.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bringup/drive/drive_world.hpp"
#include "tandem/safety_filter/safety_filter.hpp"

namespace tandem::test {

using Random = std::mt19937;

inline double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Modifies a scan as a scanner with this fault does.
using ScanFault = std::function<void(SimulatedScan&, Random&)>;
/// The twist that faulty odometry at X_WB reports, given the true twist.
using TwistFault = Twist2 (*)(const Twist2& twist, const Pose2& X_WB);

struct SensingFault {
  const char* name;
  std::function<ScanFault()> scan = {};  ///< a new one for each drive; empty: no scanner fault
  const char* reason = "";  ///< part of the reason given at the end; empty: the robot drives on
  std::vector<std::string> no_return{"inf"};
  TwistFault twist = nullptr;
  double unseen_speed = 0.15;  ///< [m/s]
};

inline ScanFault all_beams(float value) {
  return [value](SimulatedScan& scan, Random&) {
    std::fill(scan.ranges.begin(), scan.ranges.end(), value);
  };
}
inline void lose_half(SimulatedScan& scan, Random& random) {
  for (float& range : scan.ranges)
    if (random() % 2 == 0) range = std::numeric_limits<float>::quiet_NaN();
}
inline void lose_a_side(SimulatedScan& scan, Random&) {
  const auto quarter = static_cast<std::ptrdiff_t>(scan.ranges.size() / 4);
  std::fill(scan.ranges.begin() + quarter, scan.ranges.begin() + 3 * quarter,
            std::numeric_limits<float>::quiet_NaN());
}
inline void farthest_as_range_max(SimulatedScan& scan, Random&) {
  scan.form.range_max = *std::max_element(scan.ranges.begin(), scan.ranges.end());
}
inline void see_posts(SimulatedScan& scan, Random&) {
  for (std::size_t i = 0; i < scan.ranges.size(); i += 30) scan.ranges[i] = 0.25F;
}
inline ScanFault frozen() {
  return [first = std::optional<SimulatedScan>{}](SimulatedScan& scan, Random&) mutable {
    if (!first) first = scan;
    scan = *first;
  };
}

inline const std::vector<SensingFault>& sensing_faults() {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  static const std::vector<SensingFault> all{
      {.name = "None"},
      {.name = "Zeros", .scan = [] { return all_beams(0.0F); }, .reason = "gives no valid range"},
      {.name = "NaN", .scan = [] { return all_beams(kNaN); }, .reason = "gives no valid range"},
      {.name = "NoBeams",
       .scan = [] { return [](SimulatedScan& scan, Random&) { scan.ranges.clear(); }; },
       .reason = "gives no valid range"},
      {.name = "Covered", .scan = [] { return all_beams(0.2F); }, .reason = "gives no valid range"},
      {.name = "Frozen", .scan = frozen, .reason = "frozen"},
      {.name = "HalfTheBeamsLost", .scan = [] { return ScanFault{lose_half}; }},
      // At the default walking pace it may touch obstacles that it has never seen.
      {.name = "OneSideLost", .scan = [] { return ScanFault{lose_a_side}; }, .unseen_speed = 0.0},
      {.name = "OwnBody", .scan = [] { return ScanFault{see_posts}; }},
      {.name = "FarthestAsRangeMax", .scan = [] { return ScanFault{farthest_as_range_max}; }},
      {.name = "FarthestAsRangeMaxNamed",
       .scan = [] { return ScanFault{farthest_as_range_max}; },
       .reason = "varies",
       .no_return = {"inf", "range_max"}},
      {.name = "TwistOfTheWorldsFrame",
       .twist =
           [](const Twist2& twist, const Pose2& X_WB) {
             return Twist2{twist.v * std::cos(X_WB.theta), twist.w};
           }},
      {.name = "TwistOfTheWrongSign",
       .twist =
           [](const Twist2& twist, const Pose2&) {
             return Twist2{-twist.v, twist.w};
           }},
      {.name = "NoTwist", .twist = [](const Twist2&, const Pose2&) { return Twist2{}; }}};
  return all;
}

/// A room of 3 to 8 m with poles, none of them at the robot's start.
inline std::shared_ptr<const StaticMap> room_with_poles(Random& random) {
  Grid grid{0.05, {-6.0, -6.0}, 240, 240, std::vector<Cell>(57600, Cell::kFree)};
  std::vector<Eigen::Vector2d> poles;
  const double half = between(random, 1.5, 4.0);
  for (int i = 0; i < 6; ++i) {
    const double angle = between(random, -3.1, 3.1), d = between(random, 1.3, 4.0);
    poles.emplace_back(d * std::cos(angle), d * std::sin(angle));
  }
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix) {
      const Eigen::Vector2d p = grid.center(ix, iy);
      bool occupied = p.cwiseAbs().maxCoeff() > half;
      for (const auto& pole : poles) occupied = occupied || (p - pole).norm() < 0.12;
      if (occupied) grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
    }
  return std::make_shared<const StaticMap>(std::move(grid));
}

/// One drive of 15 s with a person who pushes forward half of the time and in random directions
/// otherwise. In every second drive the fault is present from the start.
class FaultyDrive {
 public:
  FaultyDrive(unsigned seed, const SensingFault& fault)
      : random_{seed},
        fault_{fault},
        spoil_{fault.scan ? fault.scan() : ScanFault{}},
        fault_begins_{seed % 2 == 1 ? 0.0 : between(random_, 1.0, 6.0)},
        sim_{{}, {}, room_with_poles(random_), seed},
        sensing_{builder_params(fault)},
        filter_{filter_params(fault), RobotParams{}} {
    sim_.reset({0.0, 0.0, between(random_, -3.1, 3.1)}, seed);
  }

  void run() {
    Twist2 wish;
    for (int n = 1; n * kTick < kDuration; ++n) {
      t_ = n * kTick;
      sim_.advance_to(t_);
      const OdometryReport report = sim_.odometry();
      const RobotState robot = state_of(report);
      sensing_.on_odometry(robot, report.X_WB, report.t, t_);
      if (n % 5 == 0) look(robot);
      if (n % 75 == 1) wish = {between(random_, -0.4, 0.8), between(random_, -1.0, 1.0)};
      if (n % 150 < 75) wish.v = 0.8;
      if (n % 2 == 0) filter_.on_command(wish, t_);
      sim_.command(filter_.update(robot, t_).twist, t_);
      travelled_ += kTick * std::abs(sim_.state().twist.v);
    }
  }

  [[nodiscard]] unsigned contacts() const { return sim_.contacts().count; }
  [[nodiscard]] double travelled() const { return travelled_; }
  /// True if the reason given at the end is the one expected for the fault.
  [[nodiscard]] bool is_named() {
    const std::string said = sensing_.trouble(t_), expected = fault_.reason;
    return expected.empty() ? said.empty() : said.find(expected) != std::string::npos;
  }

 private:
  static constexpr double kTick = 0.02, kDuration = 15.0;  // [s]

  static OctomapBuilderNodeParams builder_params(const SensingFault& fault) {
    OctomapBuilderNodeParams params;
    params.scan.no_return = fault.no_return;
    return params;
  }

  static SafetyFilterParams filter_params(const SensingFault& fault) {
    SafetyFilterParams params;
    params.unseen_speed = fault.unseen_speed;
    return params;
  }

  RobotState state_of(const OdometryReport& report) const {
    RobotState robot{compose(report.X_MW, report.X_WB), report.twist, t_, report.X_WB};
    if (fault_.twist != nullptr && t_ > fault_begins_)
      robot.twist = fault_.twist(report.twist, report.X_WB);
    return robot;
  }

  void look(const RobotState& robot) {
    SimulatedScan scan = scan_of(sim_, {});
    if (spoil_ && t_ > fault_begins_) spoil_(scan, random_);
    const auto seen = sensing_.look(scan.scan(), {}, t_);
    if (!sensing_.trouble(t_).empty()) return filter_.on_map(nullptr);
    if (!seen) return;
    MapInputParams map;
    map.map_source = "local";
    const Eigen::Vector2d p_MB = robot.X_MB.position();
    filter_.on_map(local_map_over({}, *seen, p_MB, map), unseen_ground_over({}, *seen, p_MB, map));
  }

  Random random_;
  const SensingFault& fault_;
  ScanFault spoil_;
  double fault_begins_;  // [s]
  DiffDriveSim sim_;
  LiveSensing sensing_;
  SafetyFilter filter_;
  double t_ = 0.0, travelled_ = 0.0;
};

}  // namespace tandem::test
