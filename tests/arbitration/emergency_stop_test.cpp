// SPDX-License-Identifier: Apache-2.0
#include "tandem/arbitration/emergency_stop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace tandem {
namespace {

using Awaits = EmergencyStop::Awaits;

constexpr double kRestTime = 1.0;
constexpr double kNever = std::numeric_limits<double>::infinity();  // [s]
constexpr Twist2 kPushed{0.5, 0.0};

// Pressed and released at t = 0, while the stick is pushed.
EmergencyStop released() {
  EmergencyStop stop{kRestTime};
  stop.on_user(kPushed, 0.0);
  stop.on_signal(true);
  stop.on_signal(false);
  EXPECT_TRUE(stop.release());
  return stop;
}

TEST(EmergencyStop, LatchesUntilItIsReleased) {
  EmergencyStop stop{kRestTime};
  EXPECT_EQ(stop.awaits(0.0, false), Awaits::kNothing);
  stop.on_signal(true);
  EXPECT_EQ(stop.awaits(0.0, true), Awaits::kRelease);
  EXPECT_FALSE(stop.release());  // still pressed
  stop.on_signal(false);
  EXPECT_EQ(stop.awaits(9.0, true), Awaits::kRelease);
  EXPECT_TRUE(stop.release());
  EXPECT_FALSE(stop.latched());
}

TEST(EmergencyStop, SilenceDoesNotCountAsReleased) {
  EmergencyStop stop = released();
  EXPECT_EQ(stop.awaits(1.1, false), Awaits::kLettingGo);
  stop.on_user(kPushed,
               1.1);  // the link that was lost is back, and the stick was held all the time
  EXPECT_EQ(stop.awaits(1.1, false), Awaits::kLettingGo);
  EXPECT_EQ(stop.awaits(1e6, false), Awaits::kLettingGo);
  EXPECT_EQ(stop.awaits(1e6, true), Awaits::kLettingGo) << "nor for autonomy";
}

TEST(EmergencyStop, AStickReportedAtRestForASecondCountsAsReleased) {
  EmergencyStop stop = released();
  for (double t = 0.1; t < 1.05; t += 0.1) {
    stop.on_user({}, t);
    EXPECT_EQ(stop.awaits(t, false), Awaits::kLettingGo) << t;
  }
  stop.on_user({}, 1.2);
  EXPECT_EQ(stop.awaits(1.2, false), Awaits::kSteering);
  stop.on_user(kPushed, 1.3);
  EXPECT_EQ(stop.awaits(1.3, false), Awaits::kNothing);
}

// A single zero command, as sent by teleop, teleop_twist_joy and teleop_twist_keyboard.
TEST(EmergencyStop, ADeviceThatSendsOneZeroAndFallsSilentCountsAsReleased) {
  EmergencyStop stop = released();
  stop.on_user({}, 0.1);
  EXPECT_EQ(stop.awaits(1.05, false), Awaits::kLettingGo);
  EXPECT_EQ(stop.awaits(1.15, false), Awaits::kSteering);
  stop.on_user(kPushed, 5.0);
  EXPECT_EQ(stop.awaits(5.0, false), Awaits::kNothing);
}

TEST(EmergencyStop, SteeringSoonAfterARestIsNotARestart) {
  EmergencyStop stop = released();
  for (double t = 0.5; t < 20.0; t += 1.0) {
    stop.on_user({}, t);
    stop.on_user(kPushed, t + 0.9);
    EXPECT_EQ(stop.awaits(t + 0.9, false), Awaits::kLettingGo);
  }
  EXPECT_EQ(stop.awaits(1e6, false), Awaits::kLettingGo);
}

TEST(EmergencyStop, ARestBeforeTheReleaseCountsAndSteeringBeforeItDoesNot) {
  EmergencyStop stop{kRestTime};
  stop.on_user(kPushed, 0.0);
  stop.on_signal(true);
  stop.on_user({}, 0.2);
  EmergencyStop pushed = stop;
  stop.on_signal(false);
  ASSERT_TRUE(stop.release());
  EXPECT_EQ(stop.awaits(2.0, false), Awaits::kSteering);
  pushed.on_user(kPushed, 2.0);
  pushed.on_signal(false);
  ASSERT_TRUE(pushed.release());
  EXPECT_EQ(pushed.awaits(9.0, false), Awaits::kLettingGo);
}

TEST(EmergencyStop, AutonomyNeedsNoSteeringButTheStickLetGo) {
  EmergencyStop stop = released();
  EXPECT_EQ(stop.awaits(0.5, true), Awaits::kLettingGo);
  stop.on_user({}, 0.5);
  EXPECT_EQ(stop.awaits(1.5, true), Awaits::kNothing);
}

TEST(EmergencyStop, WhereNobodyEverSteeredAutonomyMayStartAndAFirstPushMayNot) {
  EmergencyStop stop{kRestTime};
  stop.on_signal(true);
  stop.on_signal(false);
  ASSERT_TRUE(stop.release());
  EmergencyStop first_push = stop;
  EXPECT_EQ(stop.awaits(0.0, true), Awaits::kNothing);
  first_push.on_user(kPushed, 5.0);
  EXPECT_EQ(first_push.awaits(5.0, false), Awaits::kLettingGo);
  EXPECT_EQ(first_push.awaits(5.0, true), Awaits::kLettingGo);
}

TEST(EmergencyStop, AClockResetRestartsARestUnderWay) {
  EmergencyStop stop = released();
  stop.on_user({}, 60.0);
  stop.on_time_jump(3.0);
  EXPECT_EQ(stop.awaits(3.9, false), Awaits::kLettingGo);
  EXPECT_EQ(stop.awaits(4.0, false), Awaits::kSteering);
}

// Whatever arrives and is lost: a push restarts the robot only if the command before it was at
// rest, and no other steered for a second.
TEST(EmergencyStop, OnlyARestReceivedAtLeastARestTimeAgoAllowsARestart) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> step{0.0, 0.4};
  int restarts = 0;
  for (int drive = 0; drive < 20000; ++drive) {
    EmergencyStop stop = released();
    double rest_since = kNever;
    double t = 0.0;
    for (int i = 0; i < 30; ++i) {
      t += random() % 8 == 0 ? 4.0 * step(random) : step(random);  // at times the link is lost
      const bool pushed = random() % 6 == 0;
      stop.on_user(pushed ? kPushed : Twist2{}, t);
      if (!pushed) rest_since = std::min(rest_since, t);
      const bool may_move = pushed && t - rest_since >= kRestTime;
      ASSERT_EQ(stop.awaits(t, false) == Awaits::kNothing, may_move);
      if (pushed) rest_since = kNever;
      if (!may_move) continue;
      ++restarts;
      break;
    }
  }
  EXPECT_GT(restarts, 1000);
}

}  // namespace
}  // namespace tandem
