// SPDX-License-Identifier: Apache-2.0
// Compares odometry's twist with the motion of odometry's own poses.
#pragma once

#include <deque>
#include <optional>

#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Bounds on the difference between poses and twist of correct odometry, and on how commands act.
struct TwistCheckBounds {
  double resolution = 0.01;    ///< resolution of each pose [m, rad]
  double age = 0.0;            ///< largest age of odometry on arrival [s]
  double slip = 0.0;           ///< fraction of the travel by which poses and twist may differ [1]
  double command_delay = 0.0;  ///< longest time from sending a command to its first effect [s]
};

/// How far the true twist may lie below and above the measured one, each ≥ 0 [m/s, rad/s].
struct TwistError {
  Twist2 below, above;  ///< [m/s], [rad/s]

  bool operator==(const TwistError&) const = default;
};

/// Checks odometry against its poses and the commands that were sent, for v and w separately.
///
/// Over a window from an earlier sample to the newest one, at least kShortestWindow long, the poses
/// travel the distance P. The twists, which are assumed to stay between their values at
/// neighbouring samples, travel a distance in [L, H]. With the tolerance
///
///   ε = 2 resolution + age |P| / T + slip |P|         over the window's duration T             (1)
///
/// the window contradicts the twist if P is outside [L − ε, H + ε]; it confirms the twist if it
/// does not contradict it and |P| > 2 ε. One contradicting window outweighs all confirming ones.
///
/// A confirmed twist is trusted. If it is contradicted, the speed may be anything the poses allow,
/// [P − ε, P + ε] / T in the shortest window, or anything a command of that time asked for, because
/// the robot may have followed it by now. If it is neither, the robot has hardly moved yet: if no
/// recent command has the twist's sign, the true speed may have the opposite sign and be as fast as
/// those commands.
///
/// Poses must be odometry's own: corrections by a localiser are not motion. Times are seconds on
/// one monotonic clock.
class TwistCheck {
 public:
  static constexpr double kShortestWindow = 0.2;  ///< [s]
  static constexpr double kLongestWindow = 1.0;   ///< [s]
  static constexpr double kLongestGap = 0.35;     ///< [s] over a longer gap no interpolation

  /// Begins without samples, so that nothing is doubted.
  explicit TwistCheck(const TwistCheckBounds& bounds) : bounds_{bounds} {}

  /// Takes the robot's pose in the odometry frame W and its twist, which arrived at time t.
  void on_odometry(const Pose2& X_WB, const Twist2& twist, double t);
  /// Takes the command that was sent to the base at time t [s].
  void on_command(const Twist2& twist, double t);
  /// Discards all data; call it when the clock is set back.
  void clear();

  /// Bounds on the error of the newest twist; zero as long as no odometry was received.
  [[nodiscard]] TwistError error(const Twist2& measured) const;
  /// Whether some window contradicts the twist.
  [[nodiscard]] bool is_contradicted() const;
  /// Lowest speed that the poses allow over the shortest window, absolute [m/s, rad/s].
  [[nodiscard]] Twist2 least_speed() const;

 private:
  // Distances since the first sample: by the poses, and the least and greatest by the twists.
  struct Ways {
    double posed = 0.0, low = 0.0, high = 0.0;
  };
  struct Sample {
    double t;
    Pose2 X_WB;
    Twist2 twist;
    Ways forward, turned;
  };
  enum class Verdict { kUndecided, kConfirmed, kContradicted };
  // Result of all windows for one component.
  struct Axis {
    Verdict verdict = Verdict::kUndecided;
    double low = 0.0, high = 0.0;  // speeds that the poses allow in the shortest window
  };
  struct Error {
    double below = 0.0, above = 0.0;
  };

  [[nodiscard]] Axis check_windows(Ways Sample::*axis) const;
  [[nodiscard]] double tolerance(double way, double duration) const;
  [[nodiscard]] static Error error_of(const Axis& axis, double measured, double lowest,
                                      double highest, double still);
  [[nodiscard]] double duration() const;

  TwistCheckBounds bounds_;
  std::deque<Sample> samples_;            // oldest first
  std::deque<Stamped<Twist2>> commands_;  // oldest first
  Axis v_, w_;
};

}  // namespace tandem
