// SPDX-License-Identifier: Apache-2.0
// Drives a robot whose scanner has blind sectors, with the filter, and checks independently of the
// map which ground its beams and its outline have covered.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bringup/drive/drive_world.hpp"
#include "tandem/model/footprint.hpp"
#include "tandem/safety_filter/safety_filter.hpp"

namespace tandem::test {

/// The ground that beams and the outline have covered, and what the outline entered without cover.
class CoverageJudge {
 public:
  // of a cell, which counts as covered if a beam touches it [m]
  static constexpr double kSide = 0.05;
  // tolerance beyond the outline's past area, for rounding [m]
  static constexpr double kEdge = 0.003;
  // ground that the outline reached within this time counts as entered now [s]
  static constexpr double kNow = 0.1;

  explicit CoverageJudge(const RobotParams& robot) : robot_{robot} {}

  void beam(const Pose2& X_MB, double angle, double length, double t) {
    const double c = std::cos(X_MB.theta + angle), s = std::sin(X_MB.theta + angle);
    const auto to_edge = [](double x, double slope) {
      if (slope == 0.0) return 1e9;
      const double cell = x / kSide;
      const double edge = slope > 0.0 ? std::floor(cell) + 1.0 : std::ceil(cell) - 1.0;
      return (edge - cell) * kSide / slope;
    };
    for (double way = 0.0; way < length;) {
      const double step =
          std::max(1e-9, std::min(to_edge(X_MB.x + way * c, c), to_edge(X_MB.y + way * s, s)));
      const double middle = way + 0.5 * step;
      covered_[key(X_MB.x + middle * c, X_MB.y + middle * s)] = t;
      way += step;
    }
  }
  void outline(const Pose2& X_MB, double t) { stood_.push_back({X_MB, t}); }

  /// True if the outline at X_MB enters, at time t, ground that nothing has covered for `timeout`.
  [[nodiscard]] bool is_driven_into_unseen(const Pose2& X_MB, double t, double timeout) const {
    constexpr int kPoints = 24;
    const double c = std::cos(X_MB.theta), s = std::sin(X_MB.theta);
    for (int i = 0; i <= kPoints; ++i)
      for (int j = 0; j <= kPoints; ++j) {
        if (i % kPoints != 0 && j % kPoints != 0) continue;  // the edge
        const double x = robot_.center_x + 0.5 * robot_.length * (2.0 * i / kPoints - 1.0);
        const double y = 0.5 * robot_.width * (2.0 * j / kPoints - 1.0);
        const Eigen::Vector2d p{X_MB.x + c * x - s * y, X_MB.y + s * x + c * y};
        const auto seen = covered_.find(key(p.x(), p.y()));
        if ((seen == covered_.end() || seen->second < t - timeout) && !was_under(p, t, timeout))
          return true;
      }
    return false;
  }

 private:
  struct Stand {
    Pose2 X_MB;
    double t;
  };

  static std::int64_t key(double x, double y) {
    return static_cast<std::int64_t>(std::floor(x / kSide)) * 1'000'000 +
           static_cast<std::int64_t>(std::floor(y / kSide));
  }
  [[nodiscard]] bool was_under(const Eigen::Vector2d& p_MQ, double t, double timeout) const {
    return std::any_of(stood_.begin(), stood_.end(), [&](const Stand& stand) {
      if (stand.t > t - kNow || stand.t < t - timeout) return false;
      const Eigen::Vector2d p = transform(inverse(stand.X_MB), p_MQ);
      return std::abs(p.x() - robot_.center_x) <= 0.5 * robot_.length + kEdge &&
             std::abs(p.y()) <= 0.5 * robot_.width + kEdge;
    });
  }

  RobotParams robot_;
  std::unordered_map<std::int64_t, double> covered_;
  std::vector<Stand> stood_;
};

/// The algorithm cores of a drive with one scanner: simulator, builder and filter.
class BlindDrive {
 public:
  struct Settings {
    RobotParams robot{};
    double scan_angle = std::numbers::pi;
    double coverage_timeout = 30.0;
    double unseen_speed = 0.15;
  };

  BlindDrive(const Settings& settings, std::shared_ptr<const StaticMap> world, const Pose2& start)
      : settings_{settings},
        sim_{{}, settings.robot, std::move(world), 1},
        sensing_{builder_params()},
        filter_{filter_params(), settings.robot},
        judge_{settings.robot} {
    sim_.reset(start, 1);
    run({}, 1.5);  // the first scans
    max_speed_over_unseen_ = 0.0;
  }

  /// Holds the stick for this long, or until `done`.
  void run(const Twist2& stick, double duration, const std::function<bool()>& done = {}) {
    for (const double end = t_ + duration; t_ < end - 1e-9 && !(done && done());) tick(stick);
  }

  [[nodiscard]] const Pose2& X() const { return sim_.state().X_MB; }
  [[nodiscard]] const Twist2& twist() const { return sim_.state().twist; }
  [[nodiscard]] unsigned collisions() const { return sim_.contacts().count; }
  [[nodiscard]] double t() const { return t_; }
  /// Counts each reason that the filter gave since the last call.
  [[nodiscard]] std::map<FilterReason, int> take_reasons() { return std::exchange(reasons_, {}); }
  /// Speed of the outline's fastest point while over ground unseen for coverage_timeout [m/s].
  [[nodiscard]] double max_speed_over_unseen() const { return max_speed_over_unseen_; }
  [[nodiscard]] int looks_over_unseen() const { return looks_over_unseen_; }

 private:
  static constexpr double kTick = 0.01;  // [s]
  // [s] a map may be one scan old, and is used for another scan
  static constexpr double kLate = 0.25;

  [[nodiscard]] DiffDriveSimNodeParams sim_params() const {
    DiffDriveSimNodeParams params;
    params.robot = settings_.robot;
    params.scan_angle = settings_.scan_angle;
    return params;
  }
  [[nodiscard]] OctomapBuilderNodeParams builder_params() const {
    OctomapBuilderNodeParams params;
    params.robot = settings_.robot;
    params.map.coverage_timeout = settings_.coverage_timeout;
    return params;
  }
  [[nodiscard]] SafetyFilterParams filter_params() const {
    SafetyFilterParams params;
    params.unseen_speed = settings_.unseen_speed;
    return params;
  }

  void tick(const Twist2& stick) {
    t_ += kTick;
    sim_.advance_to(t_);
    const long n = std::lround(t_ / kTick);
    if (n % 5 == 0) judge();
    const OdometryReport report = sim_.odometry();
    const RobotState robot{compose(report.X_MW, report.X_WB), report.twist, t_};
    if (n % 2 == 0) sensing_.on_odometry(robot, report.X_WB, report.t, t_);
    if (n % 5 == 0) judge_.outline(X(), t_);
    if (n % 10 == 0) look(robot);
    if (n % 4 != 0) return;
    filter_.on_command(stick, t_);
    const Filtered out = filter_.update(robot, t_);
    ++reasons_[out.reason];
    sim_.command(out.twist, t_);
  }
  void look(const RobotState& robot) {
    const auto params = sim_params();
    for (int i = 0; i < params.scan_beams; ++i) {
      const double angle = beam_angle(i, params.scan_beams, params.scan_angle);
      judge_.beam(X(), angle, std::min<double>(scan_range_of(sim_, params, X(), i), 8.0), t_);
    }
    const auto seen = sensing_.look(scan_of(sim_, params).scan(), {}, t_);
    if (!seen) return;
    MapInputParams map;
    map.map_source = "local";
    const Eigen::Vector2d p_MB = robot.X_MB.position();
    filter_.on_map(local_map_over({}, *seen, p_MB, map), unseen_ground_over({}, *seen, p_MB, map));
  }
  void judge() {
    const double fastest =
        std::hypot(std::abs(twist().v) + std::abs(twist().w) * 0.5 * settings_.robot.width,
                   twist().w * (0.5 * settings_.robot.length + std::abs(settings_.robot.center_x)));
    if (fastest < 0.01 ||
        !judge_.is_driven_into_unseen(X(), t_, settings_.coverage_timeout + kLate))
      return;
    ++looks_over_unseen_;
    max_speed_over_unseen_ = std::max(max_speed_over_unseen_, fastest);
  }

  Settings settings_;
  DiffDriveSim sim_;
  LiveSensing sensing_;
  SafetyFilter filter_;
  CoverageJudge judge_;
  double t_ = 0.0, max_speed_over_unseen_ = 0.0;
  int looks_over_unseen_ = 0;
  std::map<FilterReason, int> reasons_;
};

}  // namespace tandem::test
