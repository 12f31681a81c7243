// SPDX-License-Identifier: Apache-2.0
// Computes the robot's pose in the map from odometry and the transform map → odom.
#pragma once

#include <optional>

#include "tandem/config/params.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// The robot in the map: pose X_MB, body twist, and the time they hold for [s].
struct RobotState {
  Pose2 X_MB;                   ///< in the map
  Twist2 twist;                 ///< measured, in B
  double t = 0.0;               ///< arrival of the odometry [s]
  std::optional<Pose2> X_WB{};  ///< pose in odometry, without the localiser's correction; if known
};

/// Ages beyond which the pose or the twist counts as unknown.
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
/// must not be driven then.
class Localization {
 public:
  /// Begins without a pose. The parameters are not checked.
  explicit Localization(const LocalizationParams& params) : params_{params} {}

  /// Takes odometry that arrived at time t, `late` [s] later than usual, so it describes the time t
  /// − late. Ignored if newer odometry was received before.
  void on_odom(const Pose2& X_WB, const Twist2& twist, double t, double late = 0.0) {
    if (!is_finite(X_WB) || !is_finite(twist)) return;
    if (t - late < odom_.t) return;
    odom_ = {{X_WB, twist}, t - late};
  }
  /// Takes a transform that arrived at time t; its oldest link is `late` [s] older.
  void on_transform(const Pose2& X_MW, double t, double late = 0.0) {
    if (!is_finite(X_MW)) return;
    X_MW_ = {X_MW, t - late};
    has_localiser_ = true;
    is_static_ = false;
  }

  /// Takes a static transform, valid until a dynamic one is received.
  void on_static_transform(const Pose2& X_MW) {
    if (!is_finite(X_MW) || has_localiser_) return;
    X_MW_.value = X_MW;
    is_static_ = true;
  }

  /// Call after the clock jumped back: discards everything received before, except for a static
  /// transform.
  void on_time_jump() {
    odom_.reset();
    if (!is_static_) X_MW_.reset();
  }

  /// The state at `now` [s]; nullopt if odometry or the transform is missing or too old.
  [[nodiscard]] std::optional<RobotState> state(double now) const {
    if (!odom_.fresh(now, params_.odom_timeout)) return std::nullopt;
    const auto& [X_WB, twist] = odom_.value;
    if (params_.map_is_odom) return RobotState{X_WB, twist, odom_.t, X_WB};
    if (!is_static_ && !X_MW_.fresh(now, params_.transform_timeout)) return std::nullopt;
    return RobotState{compose(X_MW_.value, X_WB), twist, odom_.t, X_WB};
  }

  /// X_WB of the newest odometry, without the localiser's correction.
  [[nodiscard]] const Pose2& odometry() const { return odom_.value.X_WB; }

 private:
  struct Odometry {
    Pose2 X_WB;
    Twist2 twist;
  };

  LocalizationParams params_;
  Stamped<Odometry> odom_;
  Stamped<Pose2> X_MW_;
  bool has_localiser_ = false, is_static_ = false;  // of the transform
};

}  // namespace tandem
