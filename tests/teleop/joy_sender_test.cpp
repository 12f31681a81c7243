// SPDX-License-Identifier: Apache-2.0
// Tests which of several joysticks drives, and when a joystick may drive.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tandem/teleop/joy_rhythm.hpp"
#include "tandem/teleop/rest_check.hpp"
#include "tandem/teleop/stick_holder.hpp"
#include "tandem/teleop/teleop.hpp"

namespace tandem {
namespace {

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
  t_ += RestCheck::kSenderTimeout;
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
  const std::vector<int> buttons{1, 0};
  EXPECT_FALSE(frees(kDown, check_joy(axes, buttons, {}).at_rest));
  EXPECT_TRUE(frees(kDown, check_joy(axes, buttons, {.gains = {.deadzone = 0.1}}).at_rest));
}

}  // namespace
}  // namespace tandem
