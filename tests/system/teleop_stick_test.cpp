// SPDX-License-Identifier: Apache-2.0
// Tests which sticks may drive: those seen at rest, with values within their range.
#include "system/teleop_over_dds.hpp"

namespace tandem::test {
namespace {

// A pad that has not reported its axes yet, or a stick that is tilted where it lies.
TEST_F(TeleopOverDds, AStickThatWasNeverSeenAtRestMovesNothingAndSaysSo) {
  axes_ = {0.0f, 0.99f};
  buttons_ = {0, 0};
  ASSERT_TRUE(wait_beats(30));
  buttons_ = {1, 0};
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
  axes_ = {0.0f, 0.0f};
  ASSERT_TRUE(wait_until([&] { return trouble_.empty() && commands_ > 0; }));
  axes_ = {0.0f, 1.0f};
  EXPECT_TRUE(wait_for(kScale, 0.0));
}

TEST_F(TeleopOverDds, AStickThatIsPushedBeforeTheDeadManMovesNothing) {
  buttons_ = {0, 0};
  axes_ = {0.0f, 0.0f};
  ASSERT_TRUE(wait_beats(30));
  axes_ = {0.0f, 1.0f};
  ASSERT_TRUE(wait_beats(5));
  buttons_ = {1, 0};
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  EXPECT_EQ(commands_, 0);
}

// Two pads whose drivers use the same name.
TEST_F(TeleopOverDds, OneStickAtRestFreesNoOtherOfTheSameName) {
  const auto other = node_.create_publisher(topics::joy);
  ASSERT_TRUE(wait_until([&] { return other.matched() > 0; }));
  axes_ = {0.0f, 0.0f};
  buttons_ = {0, 0};
  ASSERT_TRUE(wait_beats(30));
  const auto lies = node_.create_wall_timer(0.02, [&] {
    other.publish(joy({0.0f, 0.99f}, {1, 0}));
  });
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
  buttons_ = {1, 0};
  ASSERT_TRUE(wait_until([&] { return commands_ > 0; }));
  axes_ = {0.0f, 0.5f};
  EXPECT_TRUE(wait_until([&] { return twist_.v > 0.3; }));
}

// Axes scaled to −100 … 100, for example: the meaning of 5 is unknown.
TEST_F(TeleopOverDds, AnAxisBeyondItsRangeIsReportedAndNotDrivenWith) {
  axes_ = {0.0f, 1.05f};
  take_stick();
  ASSERT_TRUE(wait_for(kScale, 0.0));
  axes_ = {0.0f, 5.0f};
  ASSERT_TRUE(wait_until([&] { return trouble_ == "axis 1 of joy is beyond axis_range"; }));
  ASSERT_TRUE(wait_beats(15));
  const long commands = commands_;
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, commands);
  buttons_ = {0, 0};
  EXPECT_TRUE(wait_for(0.0, 0.0)) << "letting go counts all the same";
}

class TeleopOfOtherRange : public TeleopOverDds {
 protected:
  TeleopOfOtherRange()
      : TeleopOverDds{{{"map_is_odom", "true"}, {"axis_range", "100.0"}, {"deadzone", "0.0"}}} {}
};

TEST_F(TeleopOfOtherRange, DrivesAsFarAsTheStickIsPushed) {
  axes_ = {0.0f, 5.0f};
  take_stick();
  EXPECT_TRUE(wait_for(0.05 * kScale, 0.0));
  axes_ = {0.0f, -100.0f};
  EXPECT_TRUE(wait_for(-kScale, 0.0));
}

class TeleopWithoutDeadMan : public TeleopOverDds {
 protected:
  TeleopWithoutDeadMan() : TeleopOverDds{{{"map_is_odom", "true"}, {"deadman_button", "-1"}}} {}
};

TEST_F(TeleopWithoutDeadMan, DrivesOnceItsStickWasSeenAtRest) {
  axes_ = {0.0f, 0.99f};
  buttons_ = {};
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
  axes_ = {0.0f, 1.0f};
  take_stick();
  EXPECT_TRUE(wait_for(kScale, 0.0));
}

class TeleopOfALooseStick : public TeleopOverDds {
 protected:
  explicit TeleopOfALooseStick(const char* deadzone = "0.05")
      : TeleopOverDds{{{"map_is_odom", "true"}, {"deadzone", deadzone}}} {
    axes_ = {0.0f, 0.08f};  // where it rests
  }
};

TEST_F(TeleopOfALooseStick, MovesNothingWhileItsRestLiesOutsideTheDeadZone) {
  ASSERT_TRUE(wait_until([&] { return trouble_ == kNotAtRest; }));
  axes_ = {0.0f, 1.0f};
  ASSERT_TRUE(wait_beats(30));
  EXPECT_EQ(commands_, 0);
}

class TeleopOfAWiderRest : public TeleopOfALooseStick {
 protected:
  TeleopOfAWiderRest() : TeleopOfALooseStick{"0.1"} {}
};

TEST_F(TeleopOfAWiderRest, DrivesIfTheDeadZoneAllowsForIt) {
  ASSERT_TRUE(wait_until([&] { return commands_ > 0; }));
  EXPECT_EQ(twist_, Twist2{});
  axes_ = {0.0f, 1.0f};
  EXPECT_TRUE(wait_for(kScale, 0.0));
}

}  // namespace
}  // namespace tandem::test
