// SPDX-License-Identifier: Apache-2.0
// Bounds the speeds a robot can have at each moment from its last measurement until it stands.
#pragma once

#include <span>
#include <vector>

#include "tandem/model/se2.hpp"
#include "tandem/model/stamped.hpp"

namespace tandem {

/// Bounds on the behaviour of the base. The motors are first-order with limited deceleration,
///
///   ds/dt = −min(a, (s − T) / τ)   while s slows toward its target T,                         (1)
///
/// with τ ≤ motor_lag and a_brake ≤ a ≤ brake_spread · a_brake; the same holds for the turn rate.
/// Acceleration is not bounded.
struct StoppingBounds {
  double command_delay = 0.0;  ///< from sending a command to its first effect [s]
  double motor_lag = 0.0;      ///< largest time constant τ [s]
  double a_brake = 0.0;        ///< weakest braking [m/s²]
  double alpha_brake = 0.0;    ///< [rad/s²]
  double brake_spread = 1.0;   ///< strongest braking, as a multiple of the weakest
};

/// Start of the motion and the command to try. Zero is in force from now + end on.
struct MotionStart {
  Twist2 measured;                        ///< holds at t_measured ≤ now
  double t_measured = 0.0;                ///< arrival of odometry [s]
  double now = 0.0;                       ///< [s]
  std::span<const Stamped<Twist2>> sent;  ///< earlier commands, oldest first
  Twist2 command;                         ///< the command to try
  double end = 0.0;                       ///< [s]
  Twist2 below, above;  ///< how far the true twist may lie below and above the measured one, ≥ 0

  /// The lowest true speed and turn rate that the measurement allows.
  [[nodiscard]] Twist2 lowest() const { return {measured.v - below.v, measured.w - below.w}; }
  /// The highest ones.
  [[nodiscard]] Twist2 highest() const { return {measured.v + above.v, measured.w + above.w}; }
};

/// Range of v and of w over the next dt; each end is a mean over dt.
struct TwistRange {
  Twist2 low, high;  ///< [m/s], [rad/s]
  double dt = 0.0;   ///< [s]
};

/// Ranges in order of time; after the last one the robot stands.
using StoppingEnvelope = std::vector<TwistRange>;

/// The ranges of v and w from t_measured until the robot stands. They start at the measured twist
/// with its bounds.
///
/// At time t any command sent in [t − command_delay, t] can be in force, or the last one before
/// that. Let T be the highest of them. The high end s of a speed's range follows
///
///   s ≥ 0, T ≥ s:   s = T at once           (the drive may be arbitrarily quick)
///   s ≥ 0, T < s:   s falls to max(T, 0) by (1) with the weakest braking and the largest lag   (2)
///   s < 0, T > s:   s rises to min(T, 0) at the strongest braking, without lag
///   s < 0, T ≤ s:   s stays                 (the drive may be arbitrarily slow)
///
/// and the low end is its mirror image. Each case bounds every drive that meets StoppingBounds,
/// because (1) decreases with s and increases with T, so that no slower motion overtakes a faster
/// one.
///
/// An exponential tail never ends. Once all ends of the ranges are below kTailSpeed, the remaining
/// travel s τ is represented by a last range of duration τ.
[[nodiscard]] StoppingEnvelope stopping_envelope(const MotionStart& start,
                                                 const StoppingBounds& bounds);

/// Speed below which stopping_envelope() closes an exponential tail [m/s, rad/s].
inline constexpr double kTailSpeed = 0.01;

/// Position of v and of w within their ranges: 0 is the low end, 1 the high end.
struct Shares {
  double v = 0.0, w = 0.0;  ///< [1]
};

/// All motions whose shares lie within `half` of `center`.
struct ShareCell {
  Shares center;     ///< in [0, 1]
  Shares half = {};  ///< ≥ 0
};

/// Twist of the motion at the cell's centre.
[[nodiscard]] inline Twist2 center_twist(const TwistRange& range, const ShareCell& cell) {
  return {range.low.v + cell.center.v * (range.high.v - range.low.v),
          range.low.w + cell.center.w * (range.high.w - range.low.w)};
}
/// Bound on how far the cell's other motions differ from the centre, per component.
[[nodiscard]] inline Twist2 half_width(const TwistRange& range, const ShareCell& cell) {
  return {cell.half.v * (range.high.v - range.low.v), cell.half.w * (range.high.w - range.low.w)};
}

/// Bounds on all motions that start at any time between t_measured and now: path [m] and turn
/// [rad], both absolute, and the speeds on the way [m/s], [rad/s]. Cheaper to compute than an
/// envelope.
struct Farthest {
  double path = 0.0, turn = 0.0, speed = 0.0, turn_rate = 0.0;  ///< [m], [rad], [m/s], [rad/s]
};
/// The bounds on all braked motions from `start`.
[[nodiscard]] Farthest farthest_motion(const MotionStart& start, const StoppingBounds& bounds);

/// Bounds over all motions of an envelope.
struct Reach {
  double path = 0.0, turn = 0.0;                ///< longest, absolute [m], [rad]
  double path_spread = 0.0, turn_spread = 0.0;  ///< between the low and high ends [m], [rad]
  double time = 0.0;                            ///< until the robot stands [s]
};
/// The bounds on the motions of an envelope.
[[nodiscard]] Reach reach(std::span<const TwistRange> envelope);

}  // namespace tandem
