// SPDX-License-Identifier: Apache-2.0
// In: the twist a robot moves with, the twist it is told. Out: the one following the other in time.
#pragma once

#include <cmath>

#include "tandem/model/se2.hpp"

namespace tandem {

/// Time constants τ of a drive that follows its command by first order [s]; 0: at once.
struct MotorLag {
  double v = 0.0, w = 0.0;

  [[nodiscard]] bool any() const { return v > 0.0 || w > 0.0; }
};

/// A command u held for t seconds, from a twist a on. Of each component
///
///   a⁺ = E a + (1 − E) u,        E = exp(−t / τ)
///   mean of a over t = φ a + (1 − φ) u,   φ = (1 − E) τ / t                                 (1)
///
/// exactly, and E = φ = 0 without a lag. The robot's pose moves by the mean.
struct LagStep {
  double decay_v = 0.0, decay_w = 0.0;  ///< E
  double share_v = 0.0, share_w = 0.0;  ///< φ

  [[nodiscard]] static LagStep over(double t, const MotorLag& lag) {
    const auto decay = [&](double tau) { return tau > 0.0 ? std::exp(-t / tau) : 0.0; };
    LagStep step{.decay_v = decay(lag.v), .decay_w = decay(lag.w)};
    if (t > 0.0) {
      step.share_v = (1.0 - step.decay_v) * lag.v / t;
      step.share_w = (1.0 - step.decay_w) * lag.w / t;
    }
    return step;
  }
  [[nodiscard]] bool any() const { return decay_v > 0.0 || decay_w > 0.0; }
  [[nodiscard]] Twist2 end(const Twist2& a, const Twist2& u) const {
    return {decay_v * a.v + (1.0 - decay_v) * u.v, decay_w * a.w + (1.0 - decay_w) * u.w};
  }
  [[nodiscard]] Twist2 mean(const Twist2& a, const Twist2& u) const {
    return {share_v * a.v + (1.0 - share_v) * u.v, share_w * a.w + (1.0 - share_w) * u.w};
  }
};

/// Where a robot is and how it moves: without a lag, `twist` is what it was told last.
struct Moving {
  Pose2 X_MB;
  Twist2 twist;
};

/// The same `t` seconds of the command `u` later: along the arc of the mean twist.
[[nodiscard]] inline Moving follow(const Moving& from, const Twist2& u, const MotorLag& lag,
                                   double t) {
  if (!lag.any()) return {integrate(from.X_MB, u, t), u};
  const LagStep step = LagStep::over(t, lag);
  return {integrate(from.X_MB, step.mean(from.twist, u), t), step.end(from.twist, u)};
}

}  // namespace tandem
