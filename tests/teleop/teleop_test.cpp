// SPDX-License-Identifier: Apache-2.0
#include "tandem/teleop/teleop.hpp"
#include "tandem/teleop/joy_rhythm.hpp"
#include "tandem/teleop/rest_check.hpp"
#include "tandem/teleop/stick_holder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace tandem {
namespace {

constexpr Pose2 kOrigin{};

// True if a stick that is held and publishes every `period` is found to be too slow.
bool is_too_seldom(double period) {
  JoyRhythm rhythm{0.12};
  bool found = false;
  for (int i = 1; i <= 20; ++i) found = rhythm.on_message(true, i * period).has_value();
  return found;
}

TEST(JoyRhythm, DistinguishesAStickThatPublishesTooRarelyFromASilentOne) {
  EXPECT_TRUE(is_too_seldom(0.2));
  EXPECT_FALSE(is_too_seldom(0.05));
  EXPECT_FALSE(is_too_seldom(2.0));
  JoyRhythm rhythm{0.12};
  for (int i = 1; i <= 20; ++i) EXPECT_FALSE(rhythm.on_message(i % 4 == 0, i * 0.2));
}

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

// The axis that drives forward.
double forward(float value, const TeleopParams& params = {}) {
  const std::array<float, 2> axes{0.0f, value};
  return read_stick(axes, {}, params).linear;
}

TEST(ReadStick, ClampsAnAxisThatExceedsItsTravelByALittle) {
  EXPECT_EQ(forward(1.0f), 1.0);
  EXPECT_EQ(forward(1.05f), 1.0);
  EXPECT_EQ(forward(-1.05f), -1.0);
}

// LUCI publishes −100 … 100; read as −1 … 1, a value of 5 would mean full speed.
TEST(ReadStick, DrivesNothingByAnAxisOfAnotherRangeUntilItIsTold) {
  for (const float value : {1.06f, -1.06f, 5.0f, 100.0f}) EXPECT_EQ(forward(value), 0.0) << value;
  const TeleopParams luci{.axis_range = 100.0, .gains = {.deadzone = 0.0}};
  EXPECT_NEAR(forward(5.0f, luci), 0.05, 1e-6);
  EXPECT_EQ(forward(-100.0f, luci), -1.0);
  EXPECT_EQ(forward(105.0f, luci), 1.0);
  EXPECT_EQ(forward(106.0f, luci), 0.0);
}

JoyCheck check_of(const std::vector<float>& axes, const std::vector<int>& buttons,
                  const TeleopParams& params = {}) {
  return check_joy(axes, buttons, params);
}

TEST(CheckJoy, SaysWhetherTheStickIsSeenAtRest) {
  EXPECT_TRUE(check_of({0.0f, 0.04f}, {1, 0}).at_rest);
  EXPECT_FALSE(check_of({0.0f, 0.06f}, {1, 0}).at_rest);
  EXPECT_FALSE(check_of({-0.06f, 0.0f}, {1, 0}).at_rest);
  EXPECT_FALSE(check_of({}, {1, 0}).at_rest) << "no axis was seen";
  EXPECT_TRUE(check_of({0.0f}, {1, 0}).at_rest) << "one that is not there moves nothing";
  EXPECT_FALSE(check_of({0.0f, std::numeric_limits<float>::quiet_NaN()}, {1, 0}).at_rest);
  EXPECT_TRUE(check_of({4.0f, 4.0f}, {1, 0}, {.axis_range = 100.0}).at_rest);
}

TEST(CheckJoy, NamesWhatIsMissingOrInvalid) {
  EXPECT_EQ(check_of({0.0f, 1.0f}, {1, 0}).trouble, "");
  EXPECT_EQ(check_of({0.0f, 1.0f}, {1, 0}).remark, "");
  EXPECT_EQ(check_of({0.0f}, {1, 0}).trouble, "joy has no axis 1 (axis_linear)");
  EXPECT_EQ(check_of({0.0f, 0.0f}, {}).trouble, "joy has no button 0 (deadman_button)");
  EXPECT_EQ(check_of({0.0f, 0.0f}, {1}).remark, "joy has no button 1 (end_button)");
  const TeleopParams no_buttons{.deadman_button = -1, .end_button = -1};
  EXPECT_EQ(check_of({0.0f, 0.0f}, {}, no_buttons).trouble, "");
  EXPECT_EQ(check_of({0.0f, 0.0f}, {}, no_buttons).remark, "");
  EXPECT_EQ(check_of({0.0f, 5.0f}, {1, 0}).trouble, "axis 1 of joy is beyond axis_range");
  EXPECT_TRUE(check_of({0.0f, 5.0f}, {1, 0}).beyond_range);
  EXPECT_FALSE(check_of({0.0f, 1.05f}, {1, 0}).beyond_range);
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(check_of({0.0f, inf}, {1, 0}).trouble, "axis 1 of joy is not finite");
  EXPECT_FALSE(check_of({0.0f, inf}, {1, 0}).beyond_range);
}

TEST(JoyValues, AreReadBackAsTheStickWhateverTheParameters) {
  const TeleopParams params{.axis_linear = 4,
                            .axis_angular = 3,
                            .deadman_button = 5,
                            .axis_range = 100.0,
                            .gains = {.deadzone = 0.0}};
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

TEST(JoyValues, NameOnlyExistingButtons) {
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

// --- somebody who has no stick here ------------------------------------------------------------

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

// --- whose stick it is, and whether it drives --------------------------------------------------

TEST(StickHolder, FollowsThePublisherThatHolds) {
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

TEST(StickHolder, AnIdleStickDoesNotReleaseOneThatFellSilent) {
  StickHolder holder{0.5};
  EXPECT_TRUE(holder.counts("page", true, 0.0));
  EXPECT_FALSE(holder.counts("pad", false, 9.0));
  EXPECT_TRUE(holder.counts("page", false, 9.1));
  EXPECT_TRUE(holder.counts("pad", false, 9.2));
}

class SeenAtRest : public testing::Test {
 protected:
  static constexpr bool kUp = false, kDown = true;        // the dead-man
  static constexpr bool kPushed = false, kAtRest = true;  // the stick

  // What comes of the same sample for `duration` [s] at 20 Hz.
  bool frees(bool deadman, bool at_rest, double duration = 0.05) {
    bool free = false;
    for (const double end = t_ + duration - 1e-9; t_ < end; t_ += 0.05)
      free = check_.frees("pad", deadman, at_rest, t_);
    return free;
  }

  RestCheck check_{TeleopParams{}.joy_timeout, true};
  double t_ = 10.0;
};

// A pad that has not reported yet, or a stick that is tilted where it lies.
TEST_F(SeenAtRest, AStickThatNeverWasDrivesNothing) {
  EXPECT_FALSE(frees(kUp, kPushed, 2.0));
  EXPECT_FALSE(frees(kDown, kPushed, 5.0));
  EXPECT_TRUE(frees(kDown, kAtRest));
  EXPECT_TRUE(frees(kDown, kPushed, 5.0));
}

TEST_F(SeenAtRest, AStickThatIsPushedBeforeTheDeadManMustComeToRestFirst) {
  EXPECT_TRUE(frees(kUp, kAtRest, 1.0));
  (void)frees(kUp, kPushed, 1.0);
  EXPECT_FALSE(frees(kDown, kPushed, 2.0));
  EXPECT_TRUE(frees(kDown, kAtRest));
  EXPECT_TRUE(frees(kDown, kPushed, 2.0));
}

TEST_F(SeenAtRest, DeadManAndAxisAtOnceAreNoPushFromRest) {
  (void)frees(kUp, kAtRest, 1.0);
  EXPECT_FALSE(frees(kDown, kPushed));
}

// The page, `tandem teleop` and the simulated driver behave like this.
TEST_F(SeenAtRest, OneSampleAtRestBeforeEachPressIsEnough) {
  for (int press = 0; press < 3; ++press) {
    EXPECT_TRUE(frees(kDown, kAtRest));
    EXPECT_TRUE(frees(kDown, kPushed, 1.0));
    (void)frees(kUp, kAtRest, 0.15);
    t_ += 5.0;  // it says nothing while nobody holds it
  }
}

TEST_F(SeenAtRest, ASilentPublisherMustBeSeenAgain) {
  (void)frees(kDown, kAtRest);
  ASSERT_TRUE(frees(kDown, kPushed, 1.0));
  t_ += RestCheck::kGone;
  EXPECT_FALSE(frees(kDown, kPushed, 2.0));
  EXPECT_TRUE(frees(kDown, kAtRest));
}

TEST_F(SeenAtRest, SamplesThatAreLateAreNoSilence) {
  (void)frees(kDown, kAtRest);
  t_ += 0.4;  // several were lost
  EXPECT_TRUE(frees(kDown, kPushed));
}

TEST_F(SeenAtRest, SamplesThatComeTooLateToCountAreNoSilence) {
  (void)frees(kDown, kAtRest);
  for (double t = 0.0; t < 2.0; t += 0.05) check_.keep("pad", t_ += 0.05);
  EXPECT_TRUE(frees(kDown, kPushed));
  t_ += 2.0;
  check_.keep("pad", t_);
  EXPECT_FALSE(frees(kDown, kPushed)) << "it was silent before";
}

TEST_F(SeenAtRest, ADisconnectedPublisherMustBeSeenAgain) {
  (void)frees(kDown, kAtRest);
  check_.forget("pad");
  EXPECT_FALSE(frees(kDown, kPushed));
}

TEST_F(SeenAtRest, OneSenderAtRestFreesNoOther) {
  (void)frees(kDown, kAtRest);
  EXPECT_FALSE(check_.frees("other", kDown, kPushed, t_));
}

TEST_F(SeenAtRest, WhatWasSeenBeforeTheClockWasSetBackDoesNotCount) {
  (void)frees(kDown, kAtRest);
  t_ -= 5.0;
  EXPECT_FALSE(frees(kDown, kPushed));
}

TEST_F(SeenAtRest, WithoutADeadManOnceIsEnough) {
  check_ = RestCheck{0.12, false};
  EXPECT_FALSE(frees(kDown, kPushed, 2.0));
  EXPECT_TRUE(frees(kDown, kAtRest));
  (void)frees(kUp, kPushed, 1.0);
  EXPECT_TRUE(frees(kDown, kPushed, 1.0));
}

// The dead zone is the user's setting.
TEST_F(SeenAtRest, AStickThatRestsOffItsCentreNeedsALargerDeadZone) {
  const std::vector<float> axes{0.0f, 0.08f};
  EXPECT_FALSE(frees(kDown, check_of(axes, {1, 0}).at_rest));
  EXPECT_TRUE(frees(kDown, check_of(axes, {1, 0}, {.gains = {.deadzone = 0.1}}).at_rest));
}

}  // namespace
}  // namespace tandem
