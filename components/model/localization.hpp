// SPDX-License-Identifier: Apache-2.0
// Computes the robot's pose in the map from odometry and the transform map → odom.
#pragma once

#include <limits>
#include <optional>

#include "tandem/config/params.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// The robot in the map: pose X_MB, body twist, and the time they hold for [s].
struct RobotState {
  Pose2 X_MB;
  Twist2 twist;
  double t = 0.0;
  std::optional<Pose2> X_WB{};  ///< pose in odometry, without the localiser's correction; if known
};

struct LocalizationParams {
  double odom_timeout = 0.15;
  double transform_timeout = 1.0;
  bool map_is_odom = false;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("odom_timeout", odom_timeout, Range{0.01, 5.0},
          "[s] the robot stops when odom has been silent for this long");
    field("transform_timeout", transform_timeout, Range{0.05, 60.0},
          "[s] the robot stops when the transform map → odom is older than this");
    field("map_is_odom", map_is_odom,
          "true: the two frames are the same, for a robot without a localiser");
  }
};

/// Composes X_MB = X_MW X_WB. Returns nullopt while either part is missing or too old: the robot
/// must not be driven then. If the clock is set back, everything received before counts as too old.
class Localization {
 public:
  explicit Localization(const LocalizationParams& params) : params_{params} {}

  /// Takes odometry that arrived at time t, `late` [s] later than usual, so it describes the time t
  /// − late. Ignored if newer odometry was received before.
  void on_odom(const Pose2& X_WB, const Twist2& twist, double t, double late = 0.0) {
    watch_clock(t);
    if (!is_finite(X_WB) || !is_finite(twist)) return;
    if (t - late < odom_time_) return;
    X_WB_ = X_WB;
    twist_ = twist;
    odom_time_ = t - late;
  }
  /// Takes a transform that arrived at time t; its oldest link is `late` [s] older.
  void on_transform(const Pose2& X_MW, double t, double late = 0.0) {
    watch_clock(t);
    if (!is_finite(X_MW)) return;
    X_MW_ = X_MW;
    transform_time_ = t - late;
    has_localiser_ = true;
    is_static_ = false;
  }

  /// Takes a static transform, valid until a dynamic one is received.
  void on_static_transform(const Pose2& X_MW) {
    if (!is_finite(X_MW) || has_localiser_) return;
    X_MW_ = X_MW;
    is_static_ = true;
  }

  [[nodiscard]] std::optional<RobotState> state(double now) {
    watch_clock(now);
    if (now - odom_time_ > params_.odom_timeout) return std::nullopt;
    if (params_.map_is_odom) return RobotState{X_WB_, twist_, odom_time_, X_WB_};
    if (!is_static_ && now - transform_time_ > params_.transform_timeout) return std::nullopt;
    return RobotState{compose(X_MW_, X_WB_), twist_, odom_time_, X_WB_};
  }

  /// X_WB of the newest odometry, without the localiser's correction.
  [[nodiscard]] const Pose2& odometry() const { return X_WB_; }

 private:
  static constexpr double kNever = -std::numeric_limits<double>::infinity();

  // After the clock jumps back, older timestamps lie in the future; discard them, or they would
  // count as fresh once the clock reaches them again.
  void watch_clock(double now) {
    if (odom_time_ > now) odom_time_ = kNever;
    if (transform_time_ > now) transform_time_ = kNever;
  }

  LocalizationParams params_;
  Pose2 X_WB_, X_MW_;
  Twist2 twist_;
  double odom_time_ = kNever, transform_time_ = kNever;  // [s]
  bool has_localiser_ = false, is_static_ = false;       // of the transform
};

}  // namespace tandem
