// SPDX-License-Identifier: Apache-2.0
// Tests how joy messages are read as stick deflections, and written.
#include "tandem/teleop/teleop.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace tandem {
namespace {

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
  const auto intent = teleop.on_stick(read_stick(joy.axes, joy.buttons, params), Pose2{}, 0.0);
  ASSERT_TRUE(intent);
  EXPECT_GT(intent->twist.v, 0.0);
  EXPECT_GT(intent->twist.w, 0.0);
}

TEST(JoyValues, NameOnlyExistingButtons) {
  const auto joy = joy_values({1.0, 1.0, true, false}, {.deadman_button = -1, .end_button = -1});
  EXPECT_TRUE(joy.buttons.empty());
}

}  // namespace
}  // namespace tandem
