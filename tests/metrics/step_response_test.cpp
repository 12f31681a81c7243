// SPDX-License-Identifier: Apache-2.0
#include "tandem/metrics/step_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tandem {
namespace {

using Signal = std::vector<Stamped<double>>;

struct Base {
  double delay, lag;
  double a_brake = 1e9, a_up = 1e9;  // [m/s²]
  double noise = 0.0;                // [m/s]
};

// Steps of two seconds to full speed, half speed, full reverse, and to zero after each.
Signal steps(double period = 0.05) {
  Signal commands;
  const double levels[] = {0.8, 0.0, 0.4, 0.0, -0.5, 0.0, 0.8, 0.0};
  for (double t = 0.0; t < 16.0; t += period)
    commands.push_back({levels[static_cast<std::size_t>(t / 2.0)], 100.0 + t});
  return commands;
}

// Odometry at 50 Hz of a base that follows the model, with bounded deceleration.
Signal driven(const Signal& commands, const Base& base) {
  constexpr double kStep = 0.001;
  std::mt19937 random{3};
  std::normal_distribution<double> noise{0.0, base.noise > 0.0 ? base.noise : 1.0};
  Signal measured;
  double y = 0.0;
  std::size_t next = 0;
  double u = 0.0;
  for (int i = 0; i < 16'000; ++i) {
    const double t = 100.0 + kStep * i;
    while (next < commands.size() && commands[next].t + base.delay <= t) u = commands[next++].value;
    const double change = (u - y) / base.lag * kStep;
    const double bound =
        (u * y < 0.0 || std::abs(u) < std::abs(y) ? base.a_brake : base.a_up) * kStep;
    y += std::clamp(change, -bound, bound);
    if (i % 20 == 0) measured.push_back({y + (base.noise > 0.0 ? noise(random) : 0.0), t});
  }
  return measured;
}

TEST(StepResponse, FindsDelayAndLagOfAFirstOrderBase) {
  for (const Base& base : {Base{0.05, 0.08}, Base{0.15, 0.02}, Base{0.0, 0.30}, Base{0.40, 0.10}}) {
    const Signal commands = steps(), measured = driven(commands, base);
    const auto found = step_response(commands, measured);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->delay, base.delay, 0.004);
    EXPECT_NEAR(found->lag, base.lag, 0.004);
    EXPECT_LT(found->residual, 0.02);
    EXPECT_EQ(found->stops, 4);
  }
}

TEST(StepResponse, ToleratesNoiseAndSlowOdometry) {
  const Signal commands = steps();
  Signal measured = driven(commands, {.delay = 0.1, .lag = 0.1, .noise = 0.03}), slow;
  for (std::size_t i = 0; i < measured.size(); i += 5) slow.push_back(measured[i]);  // 10 Hz
  const auto found = step_response(commands, slow);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->delay, 0.1, 0.02);
  EXPECT_NEAR(found->lag, 0.1, 0.03);
}

TEST(StepResponse, TellsBoundedAccelerationFromDelayAndLag) {
  const Signal commands = steps();
  for (const Base& base : {Base{0.05, 0.08, 1.5, 0.9}, Base{0.12, 0.03, 1.2, 0.5}}) {
    const auto found = step_response(commands, driven(commands, base));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->delay, base.delay, 0.01);
    EXPECT_NEAR(found->lag, base.lag, 0.015);
    EXPECT_NEAR(found->a_up, base.a_up, 0.05 * base.a_up);
    EXPECT_LT(found->residual, 0.02);
  }
}

TEST(StepResponse, FindsTheLeastDeceleration) {
  const Signal commands = steps();
  const auto found = step_response(commands, driven(commands, {0.05, 0.01, 1.2}));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->braking, 1.2, 0.12);
}

TEST(StepResponse, NeedsCommandsThatChange) {
  const Signal still(50, {0.0, 1.0}), one{{0.5, 0.0}};
  Signal steady;
  for (int i = 0; i < 50; ++i) steady.push_back({0.5, 0.05 * i});
  EXPECT_FALSE(step_response(still, steady));
  EXPECT_FALSE(step_response(steady, steady));
  EXPECT_FALSE(step_response(one, steady));
  EXPECT_FALSE(step_response(steps(), {}));
}

TEST(StepResponse, ReportsALargeResidualForABaseThatDoesNotFollow) {
  const Signal commands = steps();
  Signal measured = driven(commands, {0.05, 0.08});
  for (auto& sample : measured) sample.value = 0.2 * std::sin(7.0 * sample.t);
  EXPECT_GT(step_response(commands, measured)->residual, 0.5);
}

}  // namespace
}  // namespace tandem
