// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/handover.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace tandem {
namespace {

constexpr double kDuration = 0.3;
constexpr double kTick = 0.0125;  // the node's watchdog
constexpr double kHuge = std::numeric_limits<double>::max();

// In force at t = 0, after a start from rest.
Handover driving(const Twist2& command) {
  Handover handover{kDuration};
  EXPECT_EQ(handover.follow(command, false, 0.0), command);
  return handover;
}

// Same sign and not faster.
bool within(double out, double chosen) {
  return out * chosen >= 0.0 && std::abs(out) <= std::abs(chosen);
}

TEST(Handover, ASlowerCommandIsInForceAtOnce) {
  for (const double sign : {1.0, -1.0}) {
    Handover handover = driving({sign * 0.8, sign * -1.0});
    EXPECT_EQ(handover.follow({sign * 0.3, sign * -0.2}, true, 0.0),
              (Twist2{sign * 0.3, sign * -0.2}));
    EXPECT_EQ(handover.follow({}, true, 0.01), Twist2{});
  }
}

TEST(Handover, AReversalStopsAtOnceAndThenRamps) {
  Handover handover = driving({0.8, 1.0});
  EXPECT_EQ(handover.follow({-0.4, -0.6}, true, 0.0), Twist2{});
  EXPECT_NEAR(handover.follow({-0.4, -0.6}, false, 0.15).v, -0.2, 1e-12);
  EXPECT_EQ(handover.follow({-0.4, -0.6}, false, kDuration), (Twist2{-0.4, -0.6}));
}

TEST(Handover, AFasterCommandIsReachedLinearlyAndExactly) {
  Handover handover = driving({0.2, -0.4});
  const Twist2 faster{0.8, -1.0};
  EXPECT_EQ(handover.follow(faster, true, 0.0), (Twist2{0.2, -0.4}));
  const Twist2 half = handover.follow(faster, false, 0.15);
  EXPECT_NEAR(half.v, 0.5, 1e-12);
  EXPECT_NEAR(half.w, -0.7, 1e-12);
  EXPECT_EQ(handover.follow(faster, false, kDuration), faster);
}

// A command to turn while driving straight is no reason to stop.
TEST(Handover, KeepsTheSpeedWhileTheYawRateRamps) {
  Handover handover = driving({0.8, 0.0});
  EXPECT_EQ(handover.follow({0.8, 1.0}, true, 0.0), (Twist2{0.8, 0.0}));
  EXPECT_NEAR(handover.follow({0.8, 1.0}, false, 0.15).w, 0.5, 1e-12);
}

TEST(Handover, SlowingDownWithinARampIsNotDelayedEither) {
  Handover handover = driving({0.2, 0.0});
  (void)handover.follow({0.8, 0.0}, true, 0.0);
  ASSERT_NEAR(handover.follow({0.8, 0.0}, false, 0.2).v, 0.6, 1e-12);
  EXPECT_EQ(handover.follow({0.5, 0.0}, false, 0.2125).v, 0.5);
  EXPECT_EQ(handover.follow({0.1, 0.0}, false, 0.225).v, 0.1);
}

TEST(Handover, ARampUpToACommandThatGrowsMeanwhileEndsInTime) {
  Handover handover = driving({0.0, 0.0});
  double last = handover.follow({0.01, 0.0}, true, 0.0).v;
  for (int i = 1; i <= 24; ++i) {
    const double t = i * kTick;
    const double v = handover.follow({0.01 + 2.0 * t, 0.0}, false, t).v;
    EXPECT_LE(v - last, 0.15) << t;  // no leap at the end
    last = v;
  }
  EXPECT_DOUBLE_EQ(last, 0.01 + 2.0 * kDuration);
}

TEST(Handover, SourcesThatAlternateDoNotHoldUpARamp) {
  Handover handover = driving({0.1, 0.0});
  double v = 0.0;
  for (int i = 0; i * kTick <= kDuration + 1e-9; ++i)
    v = handover.follow({i % 2 == 0 ? 0.8 : 0.7, 0.0}, true, i * kTick).v;
  EXPECT_GE(v, 0.7);
}

// The stick is touched for less than the duration of a ramp.
TEST(Handover, ASlowdownShorterThanARampIsFollowedByAWholeOne) {
  Handover handover = driving({0.8, 0.0});
  EXPECT_EQ(handover.follow({0.06, 0.0}, true, 0.0).v, 0.06);
  EXPECT_EQ(handover.follow({0.06, 0.0}, false, 0.28).v, 0.06);
  EXPECT_EQ(handover.follow({0.8, 0.0}, true, 0.29).v, 0.06);
  EXPECT_NEAR(handover.follow({0.8, 0.0}, false, 0.44).v, 0.43, 1e-12);
}

TEST(Handover, ARobotThatStoodStartsWithTheCommandAsItIs) {
  Handover handover = driving({0.8, 0.0});
  (void)handover.follow({0.9, 0.0}, true, 0.1);
  handover.stop();
  EXPECT_EQ(handover.follow({0.9, 0.3}, false, 0.2), (Twist2{0.9, 0.3}));
}

TEST(Handover, AClockResetEndsTheRamp) {
  Handover handover{kDuration};
  (void)handover.follow({0.2, 0.0}, false, 60.0);
  ASSERT_EQ(handover.follow({0.8, 0.0}, true, 60.0).v, 0.2);
  handover.end_ramp();
  EXPECT_EQ(handover.follow({0.8, 0.0}, false, 0.0).v, 0.8);
}

TEST(Handover, ZeroDurationMeansNoRamp) {
  Handover handover{0.0};
  (void)handover.follow({0.2, 0.0}, false, 0.0);
  EXPECT_EQ(handover.follow({0.8, -kHuge}, true, 0.0), (Twist2{0.8, -kHuge}));
}

// A random command: often zero, sometimes a small step, sometimes as large as a double can be.
class Commands {
 public:
  explicit Commands(unsigned seed) : random_{seed} {}

  double component() {
    const int kind = pick(10);
    if (kind < 3) return 0.0;
    if (kind == 3) return std::copysign(kHuge, uniform_(random_));
    return uniform_(random_);
  }
  int pick(int choices) { return static_cast<int>(random_() % static_cast<unsigned>(choices)); }
  double time_step() { return pick(5) == 0 ? 0.0 : 0.05 * std::abs(uniform_(random_)); }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

TEST(Handover, IsNeverFasterThanTheChosenCommandAndEqualsItAfterItsDuration) {
  Commands commands{1};
  Handover handover{kDuration};
  std::array<Twist2, 3> sources;
  double t = 0.0, in_charge_since = 0.0;
  std::size_t source = 0;
  for (int i = 0; i < 300000; ++i) {
    t += commands.time_step();
    sources[static_cast<std::size_t>(commands.pick(3))] = {commands.component(),
                                                           commands.component()};
    const auto next = commands.pick(8) == 0 ? static_cast<std::size_t>(commands.pick(3)) : source;
    const bool changed = next != source;
    source = next;
    if (changed) in_charge_since = t;
    const Twist2 out = handover.follow(sources[source], changed, t);
    ASSERT_TRUE(is_finite(out));
    ASSERT_TRUE(within(out.v, sources[source].v)) << out.v << " of " << sources[source].v;
    ASSERT_TRUE(within(out.w, sources[source].w)) << out.w << " of " << sources[source].w;
    if (t >= in_charge_since + kDuration) {
      ASSERT_EQ(out, sources[source]) << t;
    }
  }
}

// What a ramp is for: of sources that keep their commands, none makes the robot leap.
TEST(Handover, NeverLeapsWhenSourcesThatKeepTheirCommandsTakeTurns) {
  Commands commands{2};
  for (int drive = 0; drive < 2000; ++drive) {
    std::array<double, 3> sources{};
    for (double& v : sources) v = 2.0 * commands.component();
    for (double& v : sources) v = std::clamp(v, -2.0, 2.0);
    const double fastest =
        std::max({std::abs(sources[0]), std::abs(sources[1]), std::abs(sources[2])});
    Handover handover{kDuration};
    double last = handover.follow({sources[0], 0.0}, false, 0.0).v, t = 0.0;
    std::size_t source = 0;
    for (int i = 0; i < 100; ++i) {
      const double dt = commands.time_step();
      const auto next = commands.pick(4) == 0 ? static_cast<std::size_t>(commands.pick(3)) : source;
      const double v = handover.follow({sources[next], 0.0}, next != source, t += dt).v;
      ASSERT_LE(std::abs(v) - std::abs(last), fastest * dt / kDuration + 1e-9);
      last = v;
      source = next;
    }
  }
}

}  // namespace
}  // namespace tandem
