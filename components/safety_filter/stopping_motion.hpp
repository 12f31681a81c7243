// SPDX-License-Identifier: Apache-2.0
// In: measured twist, commands sent, one to try. Out: the possible motions until the robot stands.
#pragma once

#include <span>
#include <vector>

#include "model/se2.hpp"

namespace tandem {

/// A twist and the time it was sent at [s].
struct TimedTwist {
  Twist2 twist;
  double t = 0.0;
};

/// A twist held for dt.
struct Segment {
  Twist2 twist;
  double dt = 0.0;
};

/// Segments in order of time; the robot stands at the end.
using Motion = std::vector<Segment>;

/// Bounds within which the base behaves. A first-order lag counts as delay: a ramp through it stays
/// below the same ramp delayed by its time constant, but for a tail that covers the same way.
struct StoppingBounds {
  double delay = 0.0;         ///< from a command to its full effect, lag included [s]
  double a_brake = 0.0;       ///< weakest braking [m/s²]
  double alpha_brake = 0.0;   ///< [rad/s²]
  double brake_spread = 1.0;  ///< strongest braking, as a multiple of the weakest
};

/// Where the motion starts, and the command to try: it is in force for `hold`, then zero is sent.
struct MotionStart {
  Twist2 measured;  ///< holds at t_measured ≤ now
  double t_measured = 0.0;
  double now = 0.0;
  std::span<const TimedTwist> sent;  ///< earlier commands, oldest first
  Twist2 command;
  double hold = 0.0;
};

/// The motion in which v and w run at the given shares of their ranges at every moment: 0 is the
/// low end, 1 the high one.
///
/// At time t any command can be in force that was sent in [t − delay, t], or the last one before.
/// Let T be the highest of them. The high end s of a speed's range follows
///
///   s ≥ 0, T ≥ s:   s = T at once           (the drive may be arbitrarily quick)
///   s ≥ 0, T < s:   s falls to max(T, 0) at the weakest braking                         (1)
///   s < 0, T > s:   s rises to min(T, 0) at the strongest braking
///   s < 0, T ≤ s:   s stays                 (the drive may be arbitrarily slow)
///
/// and the low end is its mirror image.
[[nodiscard]] Motion possible_motion(const MotionStart& start, const StoppingBounds& bounds,
                                     double v, double w);

/// How far apart the ends of the ranges come until rest: path [m] and turn [rad].
struct Spread {
  double path = 0.0, turn = 0.0;
};
[[nodiscard]] Spread spread(const Motion& low, const Motion& high);

/// Longest way of all these motions, path [m] and turn [rad], both absolute; longest time until the
/// robot stands [s].
struct Reach {
  double path = 0.0, turn = 0.0, time = 0.0;
};
[[nodiscard]] Reach reach(const MotionStart& start, const StoppingBounds& bounds);

}  // namespace tandem
