// SPDX-License-Identifier: Apache-2.0
// Compares odometry's twist with the way that its own poses take.
#pragma once

#include <deque>
#include <optional>

#include "tandem/model/se2.hpp"

namespace tandem {

/// By how much the poses and the twist of one honest odometry may differ, and how commands act.
struct TwistCheckBounds {
  double resolution = 0.01;    ///< to which each pose is given [m, rad]
  double age = 0.0;            ///< odometry is at most this old when it arrives [s]
  double slip = 0.0;           ///< fraction of the way by which poses and twist may differ [1]
  double command_delay = 0.0;  ///< longest, from sending a command to its first effect [s]
};

/// How far the robot's true twist may lie below and above a measured one, each ≥ 0 [m/s, rad/s].
struct TwistDoubt {
  Twist2 below, above;

  bool operator==(const TwistDoubt&) const = default;
};

/// Watches odometry and the commands that were sent. For v and for w by itself:
///
/// Over a window from an earlier sample to the newest one, at least kShortestWindow long, the poses
/// lead along the way P, and twists that hold between the values at neighbouring samples lead along
/// a way in [L, H]. With the tolerance
///
///   ε = 2 resolution + age |P| / T + slip |P|         over the window's duration T             (1)
///
/// the window contradicts the twist if P is outside [L − ε, H + ε]; it confirms the twist if it
/// does not and |P| > 2 ε. One window that contradicts outweighs all that confirm.
///
/// While the twist is confirmed it is believed. While it is contradicted the speed may be whatever
/// the poses allow, [P − ε, P + ε] / T in the shortest window, or what a command of that time asked
/// for, since the robot may have followed it by now. While neither is the case, the robot has
/// hardly moved yet: a twist whose sign is that of no command of late may be a speed of the other
/// sign, as fast as those commands.
///
/// Poses must be odometry's own: corrections by a localiser are no motion. Times are seconds on one
/// monotonic clock.
class TwistCheck {
 public:
  static constexpr double kShortestWindow = 0.2;  ///< [s]
  static constexpr double kLongestWindow = 1.0;   ///< [s]
  static constexpr double kLongestGap = 0.35;     ///< [s] over which twists are not interpolated

  explicit TwistCheck(const TwistCheckBounds& bounds) : bounds_{bounds} {}

  /// Pose of the robot in the odometry frame and its twist, which arrived at time t.
  void on_odometry(const Pose2& X_WB, const Twist2& twist, double t);
  void on_command(const Twist2& twist, double t);
  /// Forgets everything, as when the clock is set back.
  void clear();

  /// What to make of the newest twist. No doubt as long as no odometry was given.
  [[nodiscard]] TwistDoubt doubt(const Twist2& measured) const;
  /// Some window contradicts the twist.
  [[nodiscard]] bool is_contradicted() const;
  /// The slowest that the poses allow over the shortest window, absolute [m/s, rad/s].
  [[nodiscard]] Twist2 least_speed() const;

 private:
  // Ways from the first sample on: by the poses, and the least and the most by the twists.
  struct Ways {
    double posed = 0.0, low = 0.0, high = 0.0;
  };
  struct Sample {
    double t;
    Pose2 X_WB;
    Twist2 twist;
    Ways forward, turned;
  };
  struct Command {
    double t;
    Twist2 twist;
  };
  enum class Verdict { kUnseen, kConfirmed, kContradicted };
  // What the windows say of one component.
  struct Axis {
    Verdict verdict = Verdict::kUnseen;
    double low = 0.0, high = 0.0;  // speeds that the poses allow in the shortest window
  };
  struct Doubt {
    double below = 0.0, above = 0.0;
  };

  [[nodiscard]] Axis judge(Ways Sample::*axis) const;
  [[nodiscard]] double tolerance(double way, double duration) const;
  [[nodiscard]] static Doubt doubt_of(const Axis& axis, double measured, double lowest,
                                      double highest, double still);
  [[nodiscard]] double duration() const;

  TwistCheckBounds bounds_;
  std::deque<Sample> samples_;    // oldest first
  std::deque<Command> commands_;  // oldest first
  Axis v_, w_;
};

}  // namespace tandem
