// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/delay_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "local_planner/drive.hpp"

namespace tandem::test {
namespace {

using Stick = std::function<Twist2(double t)>;

Twist2 lively(double t) { return {0.4 + 0.3 * std::sin(1.3 * t), 0.6 * std::sin(2.1 * t)}; }

// Commands at 20 Hz to a robot whose odometry is seen at 50 Hz, `sensor_delay` old.
std::optional<double> estimate(const Stick& stick, double delay, double lag, double sensor_delay,
                               double seconds) {
  DelayEstimator estimator{RobotParams{}};
  Plant plant{{}, {}, delay, lag};
  std::deque<Twist2> seen;
  Twist2 command;
  constexpr double kTick = 0.01;
  const auto age = static_cast<std::size_t>(std::lround(sensor_delay / kTick));
  for (int n = 0; n * kTick < seconds; ++n) {
    const double t = n * kTick;
    if (n % 5 == 0) estimator.on_command(command = stick(t), t);
    seen.push_back(plant.twist);
    while (seen.size() > age + 1) seen.pop_front();
    if (n % 2 == 0) estimator.on_measurement(seen.front(), t);
    plant.run(command, kTick);
  }
  return estimator.delay();
}

class Delays : public testing::TestWithParam<std::array<double, 3>> {};

TEST_P(Delays, AreFoundWithinACentisecondOrTwo) {
  const auto [delay, lag, sensor] = GetParam();
  const auto found = estimate(lively, delay, lag, sensor, 10.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, delay + lag + sensor, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Loops, Delays,
                         testing::Values(std::array{0.02, 0.05, 0.02}, std::array{0.2, 0.0, 0.1},
                                         std::array{0.0, 0.0, 0.0}, std::array{0.3, 0.2, 0.1},
                                         std::array{0.05, 0.15, 0.0}));

TEST(DelayEstimator, RelearnsAfterAClockReset) {
  DelayEstimator estimator{RobotParams{}};
  const auto drive = [&](double from, double delay) {
    for (int n = 0; n < 500; ++n) {
      const double t = from + 0.02 * n;
      estimator.on_command(lively(t), t);
      estimator.on_measurement(lively(t - delay), t);
    }
    return estimator.delay();
  };
  ASSERT_NEAR(drive(1000.0, 0.1).value(), 0.1, 0.02);
  estimator.forget();
  EXPECT_NEAR(estimator.delay().value(), 0.1, 0.02);
  EXPECT_NEAR(drive(0.0, 0.3).value(), 0.3, 0.03);
}

TEST(DelayEstimator, ConcludesNothingFromASteadyCommand) {
  EXPECT_FALSE(estimate([](double) { return Twist2{0.5, 0.0}; }, 0.1, 0.0, 0.0, 30.0).has_value());
}

TEST(DelayEstimator, ConcludesNothingFromARobotThatDoesSomethingElse) {
  DelayEstimator estimator{RobotParams{}};
  for (int n = 0; n < 1000; ++n) {
    const double t = 0.02 * n;
    estimator.on_command(lively(t), t);
    estimator.on_measurement({0.3 * std::sin(5.0 * t * t), 0.5 * std::cos(0.7 * t)}, t);
  }
  EXPECT_FALSE(estimator.delay().has_value());
}

TEST(DelayEstimator, FollowsAChange) {
  DelayEstimator estimator{RobotParams{}};
  for (int n = 0; n < 3000; ++n) {
    const double t = 0.02 * n, delay = t < 20.0 ? 0.1 : 0.4;
    estimator.on_command(lively(t), t);
    estimator.on_measurement(lively(std::max(0.0, t - delay)), t);
  }
  ASSERT_TRUE(estimator.delay());
  EXPECT_NEAR(*estimator.delay(), 0.4, 0.02);
}

TEST(DelayEstimator, IgnoresNonFiniteValuesAndTimeGoingBack) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  DelayEstimator estimator{RobotParams{}};
  for (int n = 0; n < 1000; ++n) {
    const double t = 0.02 * n;
    estimator.on_command(lively(t), t);
    estimator.on_command({kNaN, 0.0}, t);
    estimator.on_command({5.0, 5.0}, t - 1.0);
    estimator.on_measurement(lively(std::max(0.0, t - 0.2)), t);
    estimator.on_measurement({kNaN, 0.0}, t + 0.01);
    estimator.on_measurement({5.0, 5.0}, t - 1.0);
  }
  ASSERT_TRUE(estimator.delay());
  EXPECT_NEAR(*estimator.delay(), 0.2, 0.02);
}

}  // namespace
}  // namespace tandem::test
