// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/stopping_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "safety_filter/scenes.hpp"

namespace tandem::test {
namespace {

double path(const StoppingEnvelope& envelope) {
  double way = 0.0;
  for (const TwistRange& range : envelope) way += range.high.v * range.dt;
  return way;
}

MotionStart braking_from(double v) {
  MotionStart start;
  start.measured = {v, 0.0};
  return start;
}

// Integral of equation (1). The exponential tail begins at the knee, at speed a τ.
TEST(StoppingMotion, AFirstOrderMotorNeedsMoreDistanceThanItsBraking) {
  for (const auto& [lag, a, v] : {std::array{0.30, 1.5, 1.5}, std::array{0.30, 2.5, 1.0},
                                  std::array{0.40, 1.0, 0.8}, std::array{0.05, 1.5, 0.8}}) {
    const double way = path(stopping_envelope(braking_from(v), {0.0, lag, a, a, 1.5}));
    EXPECT_NEAR(way, v * v / (2.0 * a) + 0.5 * a * lag * lag, 1e-9) << lag << ' ' << a << ' ' << v;
  }
}

TEST(StoppingMotion, BelowTheKneeTheDistanceIsSpeedTimesLag) {
  EXPECT_NEAR(path(stopping_envelope(braking_from(0.2), {0.0, 0.3, 1.0, 1.0, 1.5})), 0.2 * 0.3,
              1e-9);
}

TEST(StoppingMotion, WithoutLagItBrakesAtOnce) {
  EXPECT_NEAR(path(stopping_envelope(braking_from(0.8), {0.0, 0.0, 2.0, 2.0, 1.5})), 0.16, 1e-9);
}

// However the ramp to zero is rounded: a base that reverses may be at its new speed in no time.
TEST(StoppingMotion, AReversalReachesTheCommandedSpeed) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    MotionStart start = braking_from(-uniform(random, 0.01, 1.0));
    start.command = {uniform(random, 0.01, 1.0), 0.0};
    start.end = 3.0;
    const StoppingEnvelope envelope = stopping_envelope(
        start, {uniform(random, 0.0, 0.1), 0.0, uniform(random, 0.5, 3.0), 1.0, 1.5});
    double fastest = 0.0;
    for (const TwistRange& range : envelope) fastest = std::max(fastest, range.high.v);
    ASSERT_NEAR(fastest, start.command.v, 1e-12) << start.measured.v;
  }
}

// Drives within the bounds in small steps, with a random lag, braking and delay each time.
class Drive {
 public:
  Drive(const MotionStart& start, const StoppingBounds& bounds, Random& random)
      : start_{start},
        lag_{fraction(random) * bounds.motor_lag},
        brake_{bounds.a_brake * uniform(random, 1.0, bounds.brake_spread)},
        delay_{fraction(random) * bounds.command_delay},
        speeds_up_{pick(random, 2) ? 1e3 : uniform(random, 0.2, 5.0)},
        speed_{start.measured.v} {}

  // Distance travelled in the next dt after time t.
  double advance(double t, double dt) {
    const double change = target(t) - speed_;
    const bool slows = change * speed_ < 0.0;
    const double wanted = lag_ > 0.0 ? -std::expm1(-dt / lag_) * change : change;
    const double most = (slows ? brake_ : speeds_up_) * dt;
    const double before = speed_;
    speed_ += std::clamp(wanted, -most, most);
    if (slows && before * speed_ < 0.0) speed_ = 0.0;
    return 0.5 * (before + speed_) * dt;
  }

 private:
  [[nodiscard]] double target(double t) const {
    if (t >= start_.now + start_.end) return 0.0;
    if (t >= start_.now + delay_) return start_.command.v;
    double v = start_.measured.v;
    for (const auto& sent : start_.sent)
      if (sent.t + delay_ <= t) v = sent.value.v;
    return v;
  }

  MotionStart start_;
  double lag_, brake_, delay_, speeds_up_, speed_;
};

TEST(StoppingMotion, HoldsEveryDriveWithinTheBounds) {
  Random random(2);
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 300; ++i) {
    const StoppingBounds bounds{uniform(random, 0.0, 0.3), fraction(random) * 0.4,
                                uniform(random, 0.5, 3.0), 1.0, uniform(random, 1.0, 2.0)};
    MotionStart start = braking_from(uniform(random, -1.5, 1.5));
    start.now = 1.0;
    start.t_measured = uniform(random, 0.6, 1.0);
    start.command = {uniform(random, -1.5, 1.5), 0.0};
    start.end = uniform(random, 0.0, 0.6);
    const std::vector<Stamped<Twist2>> sent{{{uniform(random, -1.5, 1.5), 0.0}, 0.2},
                                            {{uniform(random, -1.5, 1.5), 0.0}, 0.8}};
    start.sent = sent;
    Drive drive(start, bounds, random);
    double t = start.t_measured, way = 0.0, low = 0.0, high = 0.0;
    for (const TwistRange& range : stopping_envelope(start, bounds)) {
      low += range.low.v * range.dt;
      high += range.high.v * range.dt;
      const int steps = static_cast<int>(std::ceil(range.dt / kStep));
      for (int k = 0; k < steps; ++k, t += range.dt / steps)
        way += drive.advance(t, range.dt / steps);
      ASSERT_LE(way, high + 2e-3) << i;
      ASSERT_GE(way, low - 2e-3) << i;
    }
  }
}

}  // namespace
}  // namespace tandem::test
