// SPDX-License-Identifier: Apache-2.0
#include "teleop/teleop.hpp"
#include "teleop/stick_holder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace tandem {
namespace {

constexpr Pose2 kOrigin{};

TEST(ReadStick, MapsAxesAndButtonsAsTheThesisDoes) {
  const std::array<float, 4> axes{0.25f, 1.0f, 0.0f, 0.0f};
  const std::array<int, 2> buttons{1, 0};
  const Stick stick = read_stick(axes, buttons, {.gains = {.deadzone = 0.0}});
  EXPECT_NEAR(stick.linear, 1.0, 1e-6);
  EXPECT_NEAR(stick.angular, 0.25, 1e-6);
  EXPECT_TRUE(stick.deadman);
  EXPECT_FALSE(stick.end);
}

TEST(ReadStick, TakesMissingOrNonFiniteInputAsRest) {
  const std::array<float, 2> axes{std::numeric_limits<float>::quiet_NaN(),
                                  std::numeric_limits<float>::infinity()};
  const Stick stick = read_stick(axes, {}, {});
  EXPECT_EQ(stick.linear, 0.0);
  EXPECT_EQ(stick.angular, 0.0);
  EXPECT_FALSE(stick.deadman);
}

TEST(ReadStick, ClampsAnAxisThatExceedsItsTravel) {
  const std::array<float, 2> axes{0.0f, 40.0f};
  EXPECT_EQ(read_stick(axes, {}, {}).linear, 1.0);
}

TEST(JoyValues, AreReadBackAsTheStickWhateverTheParameters) {
  const TeleopParams params{
      .axis_linear = 4, .axis_angular = 3, .deadman_button = 5, .gains = {.deadzone = 0.0}};
  const auto joy = joy_values({0.5, -0.25, true, false}, params);
  const Stick stick = read_stick(joy.axes, joy.buttons, params);
  EXPECT_EQ(stick.linear, 0.5);
  EXPECT_EQ(stick.angular, -0.25);
  EXPECT_TRUE(stick.deadman);
  EXPECT_FALSE(stick.end);
}

TEST(JoyValues, DriveForwardWhereADeviceOfOthersIsTurnedRound) {
  const TeleopParams params{.gains = {.scale_linear = -0.8, .scale_angular = -0.8}};
  const auto joy = joy_values({1.0, 1.0, true, false}, params);
  Teleop teleop{params};
  const auto intent = teleop.on_stick(read_stick(joy.axes, joy.buttons, params), kOrigin, 0.0);
  ASSERT_TRUE(intent);
  EXPECT_GT(intent->twist.v, 0.0);
  EXPECT_GT(intent->twist.w, 0.0);
}

TEST(JoyValues, NameNoButtonThatThereIsNot) {
  const auto joy = joy_values({1.0, 1.0, true, false}, {.deadman_button = -1, .end_button = -1});
  EXPECT_TRUE(joy.buttons.empty());
}

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

TEST(Teleop, LeaderComesBackAtOnceForWhoThrowsTheStickRound) {
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

// A leader that was driven past a place and turned round comes back as it went: bit by bit.
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

TEST(Teleop, HasNoLeaderWhileNobodyKnowsWhereTheRobotIs) {
  Teleop teleop{{}};
  const auto intent = teleop.on_stick({.linear = 1.0, .deadman = true}, std::nullopt, 0.0);
  ASSERT_TRUE(intent);
  EXPECT_FALSE(intent->X_ML);
  EXPECT_NEAR(intent->twist.v, 0.8, 1e-12);
}

TEST(StickHolder, FollowsTheOneWhoHolds) {
  StickHolder holder{0.5};
  EXPECT_TRUE(holder.counts("pad", false, 0.0));
  EXPECT_TRUE(holder.counts("page", true, 0.1));
  EXPECT_FALSE(holder.counts("pad", false, 0.2)) << "lies on the table";
  EXPECT_FALSE(holder.counts("pad", true, 0.3)) << "comes second";
  EXPECT_TRUE(holder.counts("page", true, 0.4));
  EXPECT_TRUE(holder.counts("page", false, 0.5));
  EXPECT_TRUE(holder.counts("pad", true, 0.6));
  EXPECT_TRUE(holder.counts("page", true, 1.2)) << "the pad has been silent for too long";
}

TEST(StickHolder, AStickOnTheTableDoesNotLetGoOfOneThatFellSilent) {
  StickHolder holder{0.5};
  EXPECT_TRUE(holder.counts("page", true, 0.0));
  EXPECT_FALSE(holder.counts("pad", false, 9.0));
  EXPECT_TRUE(holder.counts("page", false, 9.1));
  EXPECT_TRUE(holder.counts("pad", false, 9.2));
}

}  // namespace
}  // namespace tandem
