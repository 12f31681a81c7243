// SPDX-License-Identifier: Apache-2.0
// Models a drive that follows its commanded twist with a first-order lag.
#pragma once

#include <cmath>

#include "tandem/model/se2.hpp"

namespace tandem {

/// Time constants τ of a drive that follows its command with a first-order lag [s]; 0: no lag.
struct MotorLag {
  double v = 0.0, w = 0.0;  ///< [s]

  /// Whether one of the motors lags.
  [[nodiscard]] bool any() const { return v > 0.0 || w > 0.0; }
};

/// Response to a command u held for t seconds, starting at twist a. For each component, exactly,
///
///   a⁺ = E a + (1 − E) u,        E = exp(−t / τ)
///   mean of a over t = φ a + (1 − φ) u,   φ = (1 − E) τ / t                                 (1)
///
/// with E = φ = 0 without a lag. The pose is integrated with the mean.
struct LagStep {
  double decay_v = 0.0, decay_w = 0.0;  ///< E
  double share_v = 0.0, share_w = 0.0;  ///< φ

  /// The factors for `t` ≥ 0 [s].
  [[nodiscard]] static LagStep over(double t, const MotorLag& lag) {
    const auto decay = [&](double tau) { return tau > 0.0 ? std::exp(-t / tau) : 0.0; };
    LagStep step{.decay_v = decay(lag.v), .decay_w = decay(lag.w)};
    if (t > 0.0) {
      step.share_v = (1.0 - step.decay_v) * lag.v / t;
      step.share_w = (1.0 - step.decay_w) * lag.w / t;
    }
    return step;
  }
  /// Whether anything of the old twist is left at the end.
  [[nodiscard]] bool any() const { return decay_v > 0.0 || decay_w > 0.0; }
  /// The twist at the end: from `a` at the beginning towards the command `u`.
  [[nodiscard]] Twist2 end(const Twist2& a, const Twist2& u) const {
    return {decay_v * a.v + (1.0 - decay_v) * u.v, decay_w * a.w + (1.0 - decay_w) * u.w};
  }
  /// The mean twist over the step.
  [[nodiscard]] Twist2 mean(const Twist2& a, const Twist2& u) const {
    return {share_v * a.v + (1.0 - share_v) * u.v, share_w * a.w + (1.0 - share_w) * u.w};
  }
};

/// Pose and twist of a robot; without a lag, `twist` is the last command.
struct Moving {
  Pose2 X_MB;    ///< in the map
  Twist2 twist;  ///< over the ground
};

/// State after the command `u` was held for `t` [s]; the pose moves along the arc of the mean
/// twist.
[[nodiscard]] inline Moving follow(const Moving& from, const Twist2& u, const MotorLag& lag,
                                   double t) {
  if (!lag.any()) return {integrate(from.X_MB, u, t), u};
  const LagStep step = LagStep::over(t, lag);
  return {integrate(from.X_MB, step.mean(from.twist, u), t), step.end(from.twist, u)};
}

}  // namespace tandem
