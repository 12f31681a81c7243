// SPDX-License-Identifier: Apache-2.0
// Drives a robot that knows obstacles only from its scanner, while the scanner or the odometry
// fails.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "closed_loop/live_system.hpp"

namespace tandem::test {

using Random = std::mt19937;
using Scan = sensor_msgs::msg::LaserScan;

inline double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Modifies a scan as a scanner with this fault does.
using ScanFault = std::function<void(Scan&, Random&)>;
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
  return [value](Scan& scan, Random&) {
    std::fill(scan.ranges().begin(), scan.ranges().end(), value);
  };
}
inline void lose_half(Scan& scan, Random& random) {
  for (float& range : scan.ranges())
    if (random() % 2 == 0) range = std::numeric_limits<float>::quiet_NaN();
}
inline void lose_a_side(Scan& scan, Random&) {
  const auto quarter = static_cast<std::ptrdiff_t>(scan.ranges().size() / 4);
  std::fill(scan.ranges().begin() + quarter, scan.ranges().begin() + 3 * quarter,
            std::numeric_limits<float>::quiet_NaN());
}
inline void farthest_as_range_max(Scan& scan, Random&) {
  float farthest = 0.0F;
  for (const float range : scan.ranges())
    if (std::isfinite(range)) farthest = std::max(farthest, range);
  scan.range_max(farthest);
}
inline void see_posts(Scan& scan, Random&) {
  for (std::size_t i = 0; i < scan.ranges().size(); i += 30) scan.ranges()[i] = 0.25F;
}
inline ScanFault frozen() {
  return [first = std::optional<Scan>{}](Scan& scan, Random&) mutable {
    if (!first) first = scan;
    const auto header = scan.header();
    scan = *first;
    scan.header(header);
  };
}

inline const std::vector<SensingFault>& sensing_faults() {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  static const std::vector<SensingFault> all{
      {.name = "None"},
      {.name = "Zeros", .scan = [] { return all_beams(0.0F); }, .reason = "gives no valid range"},
      {.name = "NaN", .scan = [] { return all_beams(kNaN); }, .reason = "gives no valid range"},
      {.name = "NoBeams",
       .scan = [] { return [](Scan& scan, Random&) { scan.ranges().clear(); }; },
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
inline Grid room_with_poles(Random& random) {
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
  return grid;
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
        system_{room_with_poles(random_), Pose2{0.0, 0.0, between(random_, -3.1, 3.1)}, seed,
                parameters(fault), LiveSystem::Relayed::kSensors} {
    rt::Node& node = system_.node();
    scan_ = node.create_publisher(topics::scan);
    odom_ = node.create_publisher(topics::odom);
    true_scan_ = node.create_subscription(kTrueScan, [this](Scan scan) {
      if (spoil_ && is_faulty()) spoil_(scan, random_);
      scan_.publish(scan);
    });
    true_odom_ = node.create_subscription(kTrueOdom, [this](nav_msgs::msg::Odometry odom) {
      if (fault_.twist != nullptr && is_faulty()) spoil_twist(odom);
      odom_.publish(odom);
    });
    system_.on_truth = [this] { travelled_ += kPeriod * std::abs(system_.truth().twist.v); };
    system_.start();
  }

  void run() {
    constexpr double kDuration = 15.0, kPush = 1.5;  // [s]
    for (int i = 0; i < static_cast<int>(kDuration / kPush); ++i) {
      Twist2 wish{between(random_, -0.4, 0.8), between(random_, -1.0, 1.0)};
      if (i % 2 == 0) wish.v = 0.8;
      system_.run(wish, kPush);
    }
  }

  [[nodiscard]] unsigned contacts() const { return system_.contacts(); }
  [[nodiscard]] double travelled() const { return travelled_; }
  /// True if the reason given at the end is the one expected for the fault.
  [[nodiscard]] bool is_named() const {
    const std::string &said = system_.trouble(), expected = fault_.reason;
    return expected.empty() ? said.empty() : said.find(expected) != std::string::npos;
  }
  [[nodiscard]] const std::string& said() const { return system_.trouble(); }

 private:
  static constexpr double kPeriod = 0.02;  // [s] of the ground truth
  static constexpr rt::Topic<Scan> kTrueScan{"true_scan", topics::scan.qos};
  static constexpr rt::Topic<nav_msgs::msg::Odometry> kTrueOdom{"true_odom"};

  static std::map<std::string, LiveSystem::Values> parameters(const SensingFault& fault) {
    return {
        {"octomap_builder", {{"no_return", fmt::format("[{}]", fmt::join(fault.no_return, ", "))}}},
        {"safety_filter", {{"unseen_speed", fmt::format("{}", fault.unseen_speed)}}}};
  }

  [[nodiscard]] bool is_faulty() const { return system_.t() > fault_begins_; }

  void spoil_twist(nav_msgs::msg::Odometry& odom) const {
    const auto X_WB = from_msg(odom.pose().pose());
    const auto twist = from_msg(odom.twist().twist());
    if (X_WB && twist) odom.twist().twist(to_msg(fault_.twist(*twist, *X_WB)));
  }

  Random random_;
  const SensingFault& fault_;
  ScanFault spoil_;
  double fault_begins_;  // [s]
  double travelled_ = 0.0;
  LiveSystem system_;
  rt::Publisher<Scan> scan_;
  rt::Publisher<nav_msgs::msg::Odometry> odom_;
  rt::Subscription true_scan_, true_odom_;
};

}  // namespace tandem::test
