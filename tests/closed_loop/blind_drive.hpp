// SPDX-License-Identifier: Apache-2.0
// Drives a robot whose scanner has blind sectors, with the filter, and checks independently of the
// map which ground its beams and its outline have covered.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "closed_loop/live_system.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/model/diff_drive.hpp"
#include "tandem/model/robot.hpp"

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

/// A drive with one scanner, judged from the true poses of the robot.
class BlindDrive {
 public:
  struct Settings {
    double scan_angle = std::numbers::pi;
    double coverage_timeout = 30.0;
    double unseen_speed = 0.15;
  };

  BlindDrive(const Settings& settings, const Grid& world, const Pose2& start)
      : settings_{settings}, judge_{robot_}, system_{world, start, 1, parameters()} {
    rt::Node& node = system_.node();
    scan_ = node.create_subscription(topics::scan, [this](const auto& scan) { look(scan); });
    filter_ = node.create_subscription(topics::filter_status, [this](const auto& status) {
      ++reasons_[from_msg(status.reason_code())];
    });
    system_.on_truth = [this] { judge(); };
    system_.start();
    run({}, 1.5);  // the first scans
    max_speed_over_unseen_ = 0.0;
  }

  /// Holds the stick for this long, or until `done`.
  void run(const Twist2& stick, double duration, const std::function<bool()>& done = {}) {
    system_.run(stick, duration, done);
  }

  [[nodiscard]] const Pose2& X() const { return system_.truth().X; }
  [[nodiscard]] const Twist2& twist() const { return system_.truth().twist; }
  [[nodiscard]] unsigned collisions() const { return system_.contacts(); }
  [[nodiscard]] double t() const { return system_.t(); }
  /// Counts each reason that the filter gave since the last call.
  [[nodiscard]] std::map<Reason, int> take_reasons() { return std::exchange(reasons_, {}); }
  /// Speed of the outline's fastest point while over ground unseen for coverage_timeout [m/s].
  [[nodiscard]] double max_speed_over_unseen() const { return max_speed_over_unseen_; }
  [[nodiscard]] int looks_over_unseen() const { return looks_over_unseen_; }

 private:
  // [s] a map may be one scan old, and is used for another scan
  static constexpr double kLate = 0.25;
  static constexpr double kReach = 8.0;        // of the beams [m]
  static constexpr std::size_t kHistory = 40;  // true poses, of 0.4 s
  static constexpr int kEvery = 5;             // true poses between two that are judged

  [[nodiscard]] std::map<std::string, LiveSystem::Values> parameters() const {
    return {
        {"diff_drive_sim",
         {{"scan_angle", fmt::format("{}", settings_.scan_angle)}, {"odom_rate", "100.0"}}},
        {"octomap_builder", {{"coverage_timeout", fmt::format("{}", settings_.coverage_timeout)}}},
        {"safety_filter", {{"unseen_speed", fmt::format("{}", settings_.unseen_speed)}}}};
  }

  // The robot moves while the scanner turns.
  [[nodiscard]] Pose2 true_pose(double t) const {
    auto at = std::find_if(poses_.rbegin(), poses_.rend(), [&](const auto& p) { return p.t <= t; });
    if (at == poses_.rend()) --at;
    return integrate(at->robot.X, at->robot.twist, t - at->t);
  }

  void look(const sensor_msgs::msg::LaserScan& scan) {
    if (poses_.empty()) return;
    const double began = rt::to_seconds(scan.header().stamp());
    for (std::size_t i = 0; i < scan.ranges().size(); ++i) {
      const auto number = static_cast<double>(i);
      const double t = began + number * static_cast<double>(scan.time_increment());
      const double angle = static_cast<double>(scan.angle_min()) +
                           number * static_cast<double>(scan.angle_increment());
      judge_.beam(true_pose(t), angle, std::min<double>(scan.ranges()[i], kReach), t);
    }
  }

  void judge() {
    poses_.push_back({t(), system_.truth()});
    if (poses_.size() > kHistory) poses_.pop_front();
    if (++judged_ % kEvery != 0) return;
    const double fastest =
        std::hypot(std::abs(twist().v) + std::abs(twist().w) * 0.5 * robot_.width,
                   twist().w * (0.5 * robot_.length + std::abs(robot_.center_x)));
    if (fastest >= 0.01 &&
        judge_.is_driven_into_unseen(X(), t(), settings_.coverage_timeout + kLate)) {
      ++looks_over_unseen_;
      max_speed_over_unseen_ = std::max(max_speed_over_unseen_, fastest);
    }
    judge_.outline(X(), t());
  }

  struct Stamped {
    double t;
    Odometry robot;
  };

  Settings settings_;
  RobotParams robot_;
  CoverageJudge judge_;
  LiveSystem system_;
  std::deque<Stamped> poses_;
  int judged_ = 0;
  double max_speed_over_unseen_ = 0.0;
  int looks_over_unseen_ = 0;
  std::map<Reason, int> reasons_;
  rt::Subscription scan_, filter_;
};

}  // namespace tandem::test
