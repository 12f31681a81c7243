// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/performance.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr double kChangeTime = 0.5;  // [s] over which the change of the command is averaged
constexpr double kLongestGap = 0.5;  // [s] after a longer gap the average does not continue
constexpr double kSteers = 0.02;     // [m/s, rad/s] a smaller command is not steering
constexpr double kHysteresis = 0.1;  // [1] the share is held until it would change by more

double difference(const Twist2& a, const Twist2& b) { return std::hypot(a.v - b.v, a.w - b.w); }

double toward(double value, double target, double dt, double time) {
  return value + (target - value) * (1.0 - std::exp(-dt / time));
}

}  // namespace

void Performance::on_user(const Twist2& user, double t, const AdaptiveParams& params) {
  const double dt = user_.age(t);
  if (dt > 0.0 && dt < kLongestGap) {
    const double rate = std::min(difference(user, user_.value) / dt, 2.0 * params.unsteady);
    change_ = toward(change_, rate, dt, kChangeTime);
  }
  if (dt == 0.0) return;
  user_ = {user, t};
}

void Performance::update(const Twist2& shared, double disagreement, double t,
                         const AdaptiveParams& params) {
  const double dt = time_ < 0.0 ? 0.0 : std::clamp(t - time_, 0.0, kLongestGap);
  time_ = t;
  const bool steers = std::abs(user_.value.v) > kSteers || std::abs(user_.value.w) > kSteers;
  if (!steers) return;
  const double agreement = 1.0 - std::min(1.0, difference(user_.value, shared) / disagreement);
  const double steadiness = 1.0 - std::min(1.0, change_ / params.unsteady);
  performance_ = toward(performance_, agreement * steadiness, dt, params.time);  // (1), (2)
  const double moved = params.range * std::abs(performance_ - held_);
  if (moved > kHysteresis) held_ = performance_;
}

double Performance::share(const AdaptiveParams& params) const {
  return std::min(1.0, params.base + params.range * (1.0 - held_));  // (3)
}

}  // namespace tandem
