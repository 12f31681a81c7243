// SPDX-License-Identifier: Apache-2.0
// Drives the filter with an adversarial operator and a robot with worst-case errors within its
// bounds.
#pragma once

#include <limits>
#include <optional>

#include "safety_filter/scenes.hpp"

namespace tandem::test {

enum class Malice {
  kRandom,
  kTowardNearest,
  kBangBang,
  kTurnInPlace,
  kConstant,
  kPushAndTurn,
  kNotFinite,  ///< bursts of NaN and ±∞ during a push toward the nearest obstacle
};
inline constexpr int kMalices = 7;

/// Generates full-speed commands from the true pose.
class Adversary {
 public:
  Adversary(Malice malice, const RobotParams& robot, Random& random)
      : malice_{malice}, robot_{robot}, random_{random}, held_{any()} {}

  Twist2 command(const Pose2& X_MB, const Footprint& footprint, const StaticMap& map) {
    ++tick_;
    switch (malice_) {
      case Malice::kRandom:
        return any();
      case Malice::kTowardNearest:
        return toward_nearest(X_MB, footprint, map);
      case Malice::kBangBang:
        return {tick_ % 4 < 2 ? v(1) : v(-1), tick_ % 2 ? w(1) : w(-1)};
      case Malice::kTurnInPlace:
        return {0.0, held_.w >= 0.0 ? w(1) : w(-1)};
      case Malice::kConstant:
        return held_;
      case Malice::kPushAndTurn: {
        Twist2 twist = toward_nearest(X_MB, footprint, map);
        if (tick_ % 3 == 0) twist = {0.0, w(pick(random_, 2) ? 1 : -1)};
        return twist;
      }
      case Malice::kNotFinite:
        return tick_ % 5 < 2 ? not_finite() : toward_nearest(X_MB, footprint, map);
    }
    return {};
  }

 private:
  [[nodiscard]] double v(int sign) const { return sign > 0 ? robot_.v_max : robot_.v_min; }
  [[nodiscard]] double w(int sign) const { return sign * robot_.w_max; }
  Twist2 any() {
    return {v(pick(random_, 2) ? 1 : -1) * (pick(random_, 3) ? 1.0 : uniform(random_, 0.0, 1.0)),
            uniform(random_, -1.0, 1.0) * robot_.w_max};
  }

  Twist2 not_finite() {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInf = std::numeric_limits<double>::infinity();
    switch (pick(random_, 4)) {
      case 0:
        return {kNaN, w(1)};
      case 1:
        return {v(1), kNaN};
      case 2:
        return {kInf, -kInf};
      default:
        return {-kInf, w(-1)};
    }
  }

  // Signs that move the outline's point nearest to a cell straight at that cell.
  Twist2 toward_nearest(const Pose2& X_MB, const Footprint& footprint, const StaticMap& map) {
    double nearest = 1e9;
    Eigen::Vector2d p_BC{1.0, 0.0};
    for (const auto& p_MC : map.cells_near(X_MB.position(), circumradius(footprint) + 0.8)) {
      const Pose2 X_BM = inverse(X_MB);
      const Eigen::Vector2d q = transform(X_BM, p_MC);
      const double d = distance(footprint, q);
      if (d >= nearest) continue;
      nearest = d;
      p_BC = q;
    }
    if (nearest > 0.8) return held_;
    const ConvexPolygon& part = *std::min_element(
        footprint.parts.begin(), footprint.parts.end(),
        [&](const auto& a, const auto& b) { return distance(a, p_BC) < distance(b, p_BC); });
    Eigen::Vector2d low = part.front(), high = low;
    for (const auto& p : part) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Eigen::Vector2d p_BP = p_BC.cwiseMax(low).cwiseMin(high);
    const Eigen::Vector2d to = p_BC - p_BP;
    const double turn = p_BP.x() * to.y() - p_BP.y() * to.x();
    const double forward = std::abs(to.x()) > 0.1 * std::abs(to.y()) ? to.x() : held_.v;
    return {v(forward > 0.0 ? 1 : -1), w(turn > 0.0 ? 1 : -1)};
  }

  Malice malice_;
  RobotParams robot_;
  Random& random_;
  Twist2 held_;
  int tick_ = 0;
};

/// The filter and the simulated base in closed loop, with the worst measurements that the bounds
/// allow.
class ClosedLoop {
 public:
  ClosedLoop(const SafetyFilterParams& filter, const RobotParams& robot,
             const DiffDriveSimParams& sim, std::shared_ptr<const StaticMap> map, Random& random)
      : ClosedLoop(filter, robot, sim, robot, std::move(map), random) {}

  /// Simulates the base as `real`, while the filter assumes `robot`.
  ClosedLoop(const SafetyFilterParams& filter, const RobotParams& robot,
             const DiffDriveSimParams& sim, const RobotParams& real,
             std::shared_ptr<const StaticMap> map, Random& random)
      : params_{filter},
        random_{random},
        filter_{filter, robot},
        sim_{sim, real, map, static_cast<unsigned>(random())} {
    filter_.on_map(map);
  }

  void start_at(const Pose2& X_MB) {
    sim_.reset(X_MB, static_cast<unsigned>(random_()));
    lost_ = 0;
  }

  /// Applies a constant bias, or new noise in every tick; `multiple` of the bounds.
  void draw_pose_error(bool fresh, double multiple = 1.0) {
    fresh_error_ = fresh;
    multiple_ = multiple;
    const double angle = uniform(random_, -std::numbers::pi, std::numbers::pi);
    const double size = multiple * fraction(random_) * params_.position_error;
    error_ = {size * std::cos(angle), size * std::sin(angle),
              multiple * uniform(random_, -1.0, 1.0) * params_.heading_error};
  }

  /// One control period of length `period`: measures (late, or not at all for a while), filters and
  /// sends.
  Filtered tick(const Twist2& command, double period) {
    const double age = fraction(random_) * 0.4 * period;
    sim_.advance_to(now_ + period - age);
    watch_people();
    if (lost_ > 0) --lost_;
    if (lost_ == 0) measure(now_ + period - age);
    if (lost_ == 0 && pick(random_, 15) == 0) lost_ = 1 + pick(random_, 6);
    sim_.advance_to(now_ + period);
    now_ += period;

    if (unseen_ == 0) filter_.on_people(people_, now_);  // the tracks of the previous tick
    filter_.on_command(command, now_);
    const Filtered out = filter_.update(measured_, now_);
    sim_.command(out.twist, now_);
    return out;
  }

  /// Simulates a dead filter: no commands are sent.
  void be_silent(double duration) {
    now_ += duration;
    sim_.advance_to(now_);
  }

  [[nodiscard]] bool stands() const {
    const Twist2 twist = sim_.state().twist;
    return std::abs(twist.v) < 1e-3 && std::abs(twist.w) < 1e-3;
  }

  [[nodiscard]] const DiffDriveSim& sim() const { return sim_; }
  [[nodiscard]] DiffDriveSim& sim() { return sim_; }
  [[nodiscard]] const SafetyFilter& filter() const { return filter_; }
  [[nodiscard]] double now() const { return now_; }

 private:
  // Odometry with errors up to their bounds, and with dropouts.
  void watch_people() {
    if (sim_.people().all().empty()) return;
    if (unseen_ > 0) --unseen_;
    if (unseen_ == 0 && pick(random_, 15) == 0) unseen_ = 1 + pick(random_, 6);
    people_ = sim_.people().all();
    for (Obstacle& person : people_) {
      person.p_MO += params_.people.person_error * somewhere();
      person.v_MO += params_.people.person_speed_error * somewhere();
    }
  }
  Eigen::Vector2d somewhere() {
    const double angle = uniform(random_, -std::numbers::pi, std::numbers::pi);
    return fraction(random_) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }

  void measure(double t) {
    const OdometryReport report = sim_.odometry();
    if (fresh_error_) draw_pose_error(true, multiple_);
    const Pose2 X_MB = compose(report.X_MW, report.X_WB);
    measured_ = RobotState{{X_MB.x + error_.x, X_MB.y + error_.y, X_MB.theta + error_.theta},
                           report.twist,
                           t,
                           report.X_WB};
  }

  SafetyFilterParams params_;
  Random& random_;
  SafetyFilter filter_;
  DiffDriveSim sim_;
  std::optional<RobotState> measured_;
  std::vector<Obstacle> people_;
  int lost_ = 0;    // remaining ticks without odometry
  int unseen_ = 0;  // remaining ticks without a list of people
  Pose2 error_;
  double multiple_ = 1.0;
  bool fresh_error_ = false;
  double now_ = 0.0;
};

}  // namespace tandem::test
