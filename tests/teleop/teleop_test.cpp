// SPDX-License-Identifier: Apache-2.0
#include "tandem/teleop/teleop.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tandem {
namespace {

constexpr Pose2 kOrigin{};

TEST(Teleop, IsSilentWhileTheDeadManIsReleased) {
  Teleop teleop{{}};
  EXPECT_FALSE(teleop.on_stick({.linear = 1.0}, kOrigin, 0.0));
}

TEST(Teleop, SendsOneZeroAtRelease) {
  Teleop teleop{{}};
  ASSERT_TRUE(teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, 0.0));
  const auto release = teleop.on_stick({.linear = 1.0}, kOrigin, 0.05);
  ASSERT_TRUE(release);
  EXPECT_EQ(release->twist, Twist2{});
  EXPECT_FALSE(teleop.on_stick({.linear = 1.0}, kOrigin, 0.1));
}

TEST(Teleop, SendsTheZeroOfAReleaseThatASilenceHid) {
  Teleop teleop{{}};
  ASSERT_TRUE(teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, 0.0));
  const auto release = teleop.on_stick({}, kOrigin, 5.0);
  ASSERT_TRUE(release);
  EXPECT_EQ(release->twist, Twist2{});
  EXPECT_FALSE(teleop.on_stick({}, kOrigin, 5.05));
}

TEST(Teleop, LeaderReturnsToTheRobotWhenTheJoystickWasSilentOrTheClockSetBack) {
  const Stick ahead{.linear = 1.0, .deadman = true};
  for (const double t : {1.2, 0.5}) {
    Teleop teleop{{}};
    std::optional<Intent> intent;
    for (int i = 0; i <= 10; ++i) intent = teleop.on_stick(ahead, kOrigin, 0.1 * i);
    ASSERT_GT(intent->X_ML->x, 0.5);
    intent = teleop.on_stick(ahead, kOrigin, t);
    EXPECT_EQ(intent->X_ML->x, 0.0) << t;
    EXPECT_EQ(intent->twist.v, 0.8) << t;
  }
}

TEST(Teleop, LeaderStartsAtTheRobotAndIntegratesTheStick) {
  Teleop teleop{{.gains = {.leader_scale_linear = 0.9}}};
  const Pose2 X_MB{2.0, 1.0, 0.0};
  ASSERT_TRUE(teleop.on_stick({.linear = 1.0, .deadman = true}, X_MB, 0.0)->X_ML);
  const auto intent = teleop.on_stick({.linear = 1.0, .deadman = true}, X_MB, 0.1);
  EXPECT_NEAR(intent->X_ML->x, 2.09, 1e-9);
  EXPECT_NEAR(intent->X_ML->y, 1.0, 1e-9);
}

TEST(Teleop, LeaderNeverLeavesItsLeash) {
  Teleop teleop{{.gains = {.leash = 0.5}}};
  std::optional<Intent> intent;
  for (double t = 0.0; t < 10.0; t += 0.05) {
    intent = teleop.on_stick({.linear = 1.0, .angular = 0.3, .deadman = true}, kOrigin, t);
    ASSERT_LE(intent->X_ML->position().norm(), 0.5 + 1e-9);
  }
  EXPECT_NEAR(intent->X_ML->position().norm(), 0.5, 1e-9);
}

TEST(Teleop, LeaderReturnsImmediatelyWhenTheStickIsReversed) {
  for (const double way : {1.0, -1.0}) {
    Teleop teleop{{}};
    const Pose2 X_MB{2.0, 1.0, 0.3};
    std::optional<Intent> intent;
    double t = 0.0;
    for (; t < 3.0; t += 0.05)
      intent = teleop.on_stick({.linear = way, .angular = 0.1, .deadman = true}, X_MB, t);
    ASSERT_GT((intent->X_ML->position() - X_MB.position()).norm(), 0.8);
    const Pose2 before = *intent->X_ML;
    // A hand that only gives way, or turns, does not call.
    intent = teleop.on_stick({.linear = -0.2 * way, .deadman = true}, X_MB, t += 0.05);
    intent = teleop.on_stick({.angular = 0.1, .deadman = true}, X_MB, t += 0.05);
    EXPECT_LT((intent->X_ML->position() - before.position()).norm(), 0.02);
    intent = teleop.on_stick({.linear = -way, .deadman = true}, X_MB, t += 0.05);
    EXPECT_LT((intent->X_ML->position() - X_MB.position()).norm(), 0.05);
    EXPECT_NEAR(intent->X_ML->theta, before.theta, 0.01);
  }
}

TEST(Teleop, LeaderOfAReversedAxisReturnsWhenTheStickIsReversed) {
  TeleopParams params;
  params.gains.scale_linear *= -1.0;
  params.gains.leader_scale_linear *= -1.0;
  Teleop teleop{params};
  std::optional<Intent> intent;
  double t = 0.0;
  for (; t < 3.0; t += 0.05)
    intent = teleop.on_stick({.linear = -1.0, .deadman = true}, kOrigin, t);
  ASSERT_GT(intent->X_ML->x, 0.5);
  intent = teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, t);
  EXPECT_NEAR(intent->X_ML->x, 0.0, 0.05);
}

// A leader that was driven past a point and turned round comes back along the same path, step by
// step.
TEST(Teleop, LeaderThatWasTurnedRoundIsNotCalledBack) {
  Teleop teleop{{}};
  std::optional<Intent> intent;
  double t = 0.0;
  for (; t < 1.0; t += 0.05) intent = teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, t);
  for (; std::abs(intent->X_ML->theta) < 3.1; t += 0.05)
    intent = teleop.on_stick({.angular = 1.0, .deadman = true}, kOrigin, t);
  const double before = intent->X_ML->x;
  intent = teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, t);
  EXPECT_NEAR(intent->X_ML->x, before - 0.045, 0.005);
}

// A robot that is told to stop now goes v² / 2 a; while it does so, the place hardly moves.
TEST(Teleop, LeaderIsWhereTheRobotComesToRestWhileTheStickIsAtRest) {
  const RobotParams robot;
  for (const double way : {1.0, -1.0}) {
    Teleop teleop{{}, robot};
    const Twist2 moves{way > 0.0 ? robot.v_max : robot.v_min, 0.0};
    double t = 0.0;
    for (; t < 3.0; t += 0.05)
      (void)teleop.on_stick({.linear = way, .deadman = true}, kOrigin, t, moves);
    auto intent = teleop.on_stick({.deadman = true}, kOrigin, t, moves);
    EXPECT_NEAR(intent->X_ML->x, way * moves.v * moves.v / (2.0 * robot.a_brake), 1e-9);
    EXPECT_NEAR(intent->X_ML->y, 0.0, 1e-9);
    intent = teleop.on_stick({.deadman = true}, Pose2{0.2, 0.0, 0.3}, t + 0.05);
    EXPECT_EQ(*intent->X_ML, (Pose2{0.2, 0.0, 0.3}));
  }
}

TEST(Teleop, LeaderOfACommandAtRestIsWhereTheRobotStands) {
  Teleop teleop{{}, RobotParams{}};
  double t = 0.0;
  for (; t < 1.0; t += 0.05) (void)teleop.on_twist({0.5, 0.0}, kOrigin, t);
  EXPECT_EQ(teleop.on_twist({}, kOrigin, t)->x, 0.0);
}

TEST(Teleop, LeaderIsNoFasterThanTheRobot) {
  const RobotParams robot;  // 0.8 forward, 0.4 backward, where 0.9 is asked for
  for (const double way : {1.0, -1.0}) {
    Teleop teleop{{}, robot};
    std::optional<Intent> intent;
    for (int i = 0; i <= 10; ++i)
      intent = teleop.on_stick({.linear = way, .deadman = true}, kOrigin, 0.05 * i, {0.5, 0.0});
    EXPECT_NEAR(intent->X_ML->x, 0.5 * (way > 0.0 ? robot.v_max : robot.v_min), 1e-9);
  }
}

TEST(Teleop, LeaderOfARobotThatStandsIsTurnedOnTheSpot) {
  for (const double speed : {0.0, 0.5}) {
    Teleop teleop{{}, RobotParams{}};
    double t = 0.0;
    for (; t < 1.0; t += 0.05)
      (void)teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, t, {0.5, 0.0});
    const auto intent =
        teleop.on_stick({.angular = 1.0, .deadman = true}, kOrigin, t, {speed, 0.0});
    EXPECT_NEAR(intent->X_ML->x, speed > 0.0 ? 0.8 * 0.95 : 0.0, 1e-9);
    EXPECT_GT(intent->X_ML->theta, 0.04);
  }
}

// For sip-and-puff drives: the leader must not be recalled between two pushes in quick succession.
TEST(Teleop, LeaderGoesOnFromPulseToPulseUntilTheRestIsLong) {
  Teleop teleop{{}, RobotParams{}};
  double t = 0.0;
  std::optional<Intent> intent;
  for (; t < 0.5; t += 0.05) intent = teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, t);
  const double ahead = intent->X_ML->x;
  for (; t < 0.8; t += 0.05) intent = teleop.on_stick({.deadman = true}, kOrigin, t);
  EXPECT_EQ(intent->X_ML->x, ahead);
  for (; t < 1.0; t += 0.05) intent = teleop.on_stick({.deadman = true}, kOrigin, t);
  EXPECT_EQ(intent->X_ML->x, 0.0);
}

TEST(Teleop, GoesOnWithOtherGainsWhileTheDeadManIsHeld) {
  Teleop teleop{{}};
  const Stick ahead{.linear = 1.0, .deadman = true};
  std::optional<Intent> before;
  for (double t = 0.0; t < 0.5; t += 0.05) before = teleop.on_stick(ahead, kOrigin, t);
  EXPECT_THROW(teleop.set_gains({.leash = 99.0}), std::invalid_argument);
  teleop.set_gains({.scale_linear = 0.2});
  const auto after = teleop.on_stick(ahead, kOrigin, 0.5);
  EXPECT_EQ(after->twist.v, 0.2);
  EXPECT_GE(after->X_ML->x, before->X_ML->x);  // the leader is where it was, and drives on
}

TEST(Teleop, LeaderReturnsToTheRobotAfterRelease) {
  Teleop teleop{{}};
  for (double t = 0.0; t < 1.0; t += 0.05)
    (void)teleop.on_stick({.linear = 1.0, .deadman = true}, kOrigin, t);
  (void)teleop.on_stick({}, kOrigin, 1.0);
  const auto intent = teleop.on_stick({.deadman = true}, kOrigin, 1.05);
  EXPECT_EQ(intent->X_ML->x, 0.0);
}

TEST(Teleop, HasNoLeaderWhileTheRobotIsNotLocalised) {
  Teleop teleop{{}};
  const auto intent = teleop.on_stick({.linear = 1.0, .deadman = true}, std::nullopt, 0.0);
  ASSERT_TRUE(intent);
  EXPECT_FALSE(intent->X_ML);
  EXPECT_NEAR(intent->twist.v, 0.8, 1e-12);
}

TEST(Teleop, LeaderFollowsAnotherPublishersCommand) {
  Teleop teleop{{}};
  const Pose2 X_MB{2.0, 1.0, 0.0};
  EXPECT_EQ(teleop.on_twist({0.3, 0.0}, X_MB, 0.0)->x, 2.0);
  EXPECT_NEAR(teleop.on_twist({0.3, 0.0}, X_MB, 0.05)->x, 2.0 + 0.3 * 0.05, 1e-12);
  EXPECT_NEAR(teleop.on_twist({0.0, 0.5}, X_MB, 0.10)->theta, 0.5 * 0.05, 1e-12);
  EXPECT_FALSE(teleop.on_twist({0.3, 0.0}, std::nullopt, 0.15)) << "nobody knows where it is";
}

TEST(Teleop, LeaderOfACommandReturnsToTheRobotAfterASilence) {
  Teleop teleop{{}};
  double t = 0.0;
  for (; t < 1.0; t += 0.05) (void)teleop.on_twist({0.5, 0.0}, kOrigin, t);
  EXPECT_GT(teleop.on_twist({0.5, 0.0}, kOrigin, t)->x, 0.4);
  EXPECT_EQ(teleop.on_twist({0.5, 0.0}, kOrigin, t + 0.2)->x, 0.0);
}

TEST(Teleop, LeaderOfACommandKeepsToItsLeashWhateverIsCommanded) {
  Teleop teleop{{}};
  for (double t = 0.0; t < 2.0; t += 0.05) {
    const auto X_ML = teleop.on_twist({1e300, -1e300}, kOrigin, t);
    ASSERT_TRUE(X_ML && is_finite(*X_ML));
    ASSERT_LE(X_ML->position().norm(), StickGains{}.leash + 1e-9);
  }
}

TEST(Teleop, AHeldStickLeadsAndACommandDoesNot) {
  Teleop teleop{{}};
  const Stick back{.linear = -1.0, .deadman = true};
  for (double t = 0.0; t < 1.0; t += 0.05) (void)teleop.on_twist({0.5, 0.0}, kOrigin, t);
  EXPECT_EQ(teleop.on_stick(back, kOrigin, 1.0)->X_ML->x, 0.0) << "its leader begins anew";
  EXPECT_FALSE(teleop.on_twist({0.5, 0.0}, kOrigin, 1.02));
  EXPECT_NEAR(teleop.on_stick(back, kOrigin, 1.05)->X_ML->x, -0.9 * 0.05, 1e-12);
  (void)teleop.on_stick({}, kOrigin, 1.1);
  EXPECT_EQ(teleop.on_twist({0.5, 0.0}, kOrigin, 1.12)->x, 0.0);
}

TEST(Teleop, AStickThatLiesThereReleasedDisturbsNoCommand) {
  for (const int deadman : {0, -1}) {  // at rest without a dead-man: nobody holds it
    Teleop teleop{{.deadman_button = deadman}};
    const Stick lies{.deadman = deadman < 0};
    std::optional<Pose2> X_ML;
    for (double t = 0.0; t < 1.0; t += 0.05) {
      const auto intent = teleop.on_stick(lies, kOrigin, t + 0.02);
      EXPECT_TRUE(!intent || t == 0.0) << t;
      X_ML = teleop.on_twist({0.5, 0.0}, kOrigin, t + 0.03);
      ASSERT_TRUE(X_ML);
    }
    EXPECT_NEAR(X_ML->x, 0.5 * 0.95, 1e-9) << deadman;
  }
}

}  // namespace
}  // namespace tandem
