// SPDX-License-Identifier: Apache-2.0
// Simulates a driver who knows the route: computes stick samples from the robot's pose.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <random>
#include <vector>

#include "tandem/config/params.hpp"
#include "tandem/driver/hand.hpp"
#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Route and steering of a person who knows where to go.
struct NavigatorParams {
  static constexpr double kTurnGain = 1.6;  ///< [1/rad] stick deflection per bearing error

  std::vector<double> route;
  bool loop = false;
  double rate = 20.0;
  double reaction_delay = 0.25;
  double preview = 0.9;
  double speed = 1.0;
  double stick_noise = 0.12;
  double aim_noise = 0.25;
  double patience = 1.5;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("route", route, Range{-1e4, 1e4},
          "[m] x1, y1, x2, y2, … of the path, as known to someone familiar with the place");
    field("loop", loop, "true: the last point of the route connects to the first");
    field("rate", rate, Range{1.0, 200.0}, "[Hz] publishing rate of the joystick");
    field("reaction_delay", reaction_delay, Range{0.0, 2.0},
          "[s] reaction time from seeing to steering");
    field("preview", preview, Range{0.1, 10.0},
          "[m] look-ahead distance along the route; larger values cut corners");
    field("speed", speed, Range{0.0, 1.0}, "[1] stick deflection when the path is free");
    field("stick_noise", stick_noise, Range{0.0, 1.0},
          "[1] standard deviation of the stick deflection");
    field("aim_noise", aim_noise, Range{0.0, 5.0},
          "[m] standard deviation of the aim across the route");
    field("patience", patience, Range{0.1, 60.0},
          "[s] time of pushing without motion before backing out");
  }
};

/// A person who follows a known route, sees no obstacles, reacts late, aims imperfectly, cuts
/// corners, and backs out when pushing does not help. After each failure at the same place they
/// back out farther, cut corners less and aim better. Deterministic for a seed.
///
/// Pure pursuit of a point `preview` ahead on the route, shifted sideways by a slow error (an
/// Ornstein–Uhlenbeck process of deviation `aim_noise`), with a reaction delay of `reaction_delay`.
/// A leader that has reached that point waits for its robot, facing along the route. The stick is
/// released 0.3 m before the end.
///
/// Sources of the values: simple visual reactions take about 0.19 s, recognition among several
/// stimuli 0.38 s (Laming 1968, cited in Kosinski's review of reaction times); 0.25 s lies between,
/// because a driver anticipates. The preview of 0.9 m is at least one second at the robots' speeds,
/// as in driver models (MacAdam 1981). The other values are our choice, except `aim_noise` in
/// forest_task1.yaml, with which `manual` collides as often as Devalla's seven participants (table
/// C.2).
class Navigator {
 public:
  /// Throws std::invalid_argument if the route has no point or an odd number of coordinates.
  Navigator(const NavigatorParams& params, unsigned seed);

  /// Returns one joystick sample; call every 1 / rate seconds. `X_MB`: the robot; `X_MS`: what the
  /// stick steers, the robot itself or its leader.
  [[nodiscard]] Hand steer(const Pose2& X_MB, const Pose2& X_MS, double t);

  /// Restarts the route.
  void start_again();

  /// Whether the end of the route was reached; never, if it loops.
  [[nodiscard]] bool arrived() const { return arrived_; }

 private:
  void advance_along_route(const Eigen::Vector2d& p_MB);
  [[nodiscard]] Eigen::Vector2d point_at(double s) const;
  [[nodiscard]] bool has_route() const { return length_.back() > 0.0; }
  [[nodiscard]] Eigen::Vector2d aim(const Eigen::Vector2d& p_MB) const;
  [[nodiscard]] Eigen::Vector2d aim_at_goal(const Eigen::Vector2d& p_MB) const;
  [[nodiscard]] Hand look_along_route(const Pose2& X_MS) const;
  [[nodiscard]] Hand pursue(const Pose2& X_MS, const Eigen::Vector2d& p_MT) const;
  [[nodiscard]] Hand with_noise(Hand hand);
  [[nodiscard]] Hand reverse(const Pose2& X_MS) const;
  [[nodiscard]] double back_out_distance() const;
  [[nodiscard]] bool backs_out(const Pose2& X_MB, double t);
  void lose_patience(const Pose2& X_MB, bool wants_to_move, double t);
  double wandered(double value, double deviation, double time);

  NavigatorParams params_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<Eigen::Vector2d> route_;
  std::vector<double> length_;  // arc length at each point of the route
  double progress_ = 0.0;
  double sideways_ = 0.0, hand_linear_ = 0.0, hand_angular_ = 0.0;
  bool arrived_ = false;
  std::deque<Stamped<Pose2>> seen_;  // X_MS, oldest first

  Stamped<Pose2> moved_;  // where and when the robot last moved
  bool backing_out_ = false;
  Pose2 back_out_from_;
  double back_out_start_ = 0.0, back_out_turn_ = 0.0;
  int tries_ = 0;         // failed attempts at one place
  double trouble_ = 0.0;  // position of that place along the route [m]
  double detour_until_ = -1.0, detour_ = 0.0;
  bool started_ = false;
};

}  // namespace tandem
