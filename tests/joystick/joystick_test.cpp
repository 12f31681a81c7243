// SPDX-License-Identifier: Apache-2.0
#include "tandem/joystick/joystick.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "support/temporary_folder.hpp"
#include "tandem/joystick/joystick_devices.hpp"

namespace tandem {
namespace {

constexpr double kPeriod = 0.05;  // [s] of the default autorepeat

JoySample first(const RawJoystick& device) {
  Joystick joystick{{}};
  return joystick.update(&device, 0.0).value();
}

TEST(Joystick, LeftAndUpArePositive) {
  const auto sample = first({{32767, -32768}, {}, {}});
  EXPECT_FLOAT_EQ(sample.axes[0], -1.0F);
  EXPECT_FLOAT_EQ(sample.axes[1], 1.0F);
}

TEST(Joystick, RestsInTheDeadZoneAndGrowsEvenlyBeyondIt) {
  const auto sample = first({{1600, -1600, 17203}, {}, {}});  // 0.049, −0.049, 0.525
  EXPECT_EQ(sample.axes[0], 0.0F);
  EXPECT_EQ(sample.axes[1], 0.0F);
  EXPECT_NEAR(sample.axes[2], -0.5F, 1e-4F);
}

TEST(Joystick, HatsAreAxesBehindTheOthers) {
  const auto sample = first({{0}, {}, {{.left = true, .down = true}}});
  EXPECT_EQ(sample.axes, (std::vector<float>{0.0F, 1.0F, -1.0F}));
}

TEST(Joystick, IsSentAtEachChangeAndRepeatedInBetween) {
  Joystick joystick{{}};
  RawJoystick device{{0}, {false}, {}};
  EXPECT_TRUE(joystick.update(&device, 0.0));
  EXPECT_FALSE(joystick.update(&device, 0.01));
  device.buttons[0] = true;
  EXPECT_TRUE(joystick.update(&device, 0.02));
  EXPECT_FALSE(joystick.update(&device, 0.02 + 0.9 * kPeriod));
  EXPECT_TRUE(joystick.update(&device, 0.02 + 1.1 * kPeriod));
}

TEST(Joystick, CanPublishOnlyWhileAButtonIsHeld) {
  Joystick joystick{{.only_held = true}};
  RawJoystick device{{0}, {false}, {}};
  EXPECT_TRUE(joystick.update(&device, 0.0));
  device.axes[0] = 20000;
  EXPECT_FALSE(joystick.update(&device, 1.0));
  device.buttons[0] = true;
  EXPECT_TRUE(joystick.update(&device, 2.0));
  EXPECT_TRUE(joystick.update(&device, 3.0));
  device.buttons[0] = false;
  EXPECT_EQ(joystick.update(&device, 3.1)->buttons, std::vector<int>{0});
  EXPECT_FALSE(joystick.update(&device, 4.0));
}

TEST(Joystick, ReleasesEverythingWhenTheDeviceDisconnects) {
  Joystick joystick{{}};
  RawJoystick device{{0}, {false}, {}};
  (void)joystick.update(&device, 0.0);
  device = {{-32768}, {true}, {}};
  EXPECT_EQ(joystick.update(&device, 0.1)->buttons, std::vector<int>{1});
  const auto gone = joystick.update(nullptr, 0.2);
  ASSERT_TRUE(gone);
  EXPECT_EQ(*gone, (JoySample{{0.0F}, {0}}));
  EXPECT_FALSE(joystick.update(nullptr, 0.3));
}

TEST(Joystick, AButtonHeldAtConnectionCountsFromItsNextPress) {
  Joystick joystick{{}};
  RawJoystick device{{}, {true, false}, {}};
  for (int plugged = 0; plugged < 2; ++plugged) {
    device.buttons = {true, false};
    EXPECT_EQ(joystick.update(&device, 0.0)->buttons, (std::vector<int>{0, 0}));
    device.buttons = {true, true};
    EXPECT_EQ(joystick.update(&device, 0.1)->buttons, (std::vector<int>{0, 1}));
    device.buttons = {false, true};
    (void)joystick.update(&device, 0.2);
    device.buttons = {true, true};
    EXPECT_EQ(joystick.update(&device, 0.3)->buttons, (std::vector<int>{1, 1}));
    (void)joystick.update(nullptr, 0.4);
  }
}

class InputClass : public testing::Test {
 protected:
  // `axes`: as the kernel prints them.
  void add(const std::string& device, const std::string& axes) const {
    const auto capabilities = folder_.path() / device / "device/capabilities";
    std::filesystem::create_directories(capabilities);
    std::ofstream{capabilities / "abs"} << axes << "\n";
  }
  [[nodiscard]] bool may_have() const { return may_have_joystick(folder_.path()); }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(InputClass, MayHaveAJoystickIfADeviceHasAxes) {
  EXPECT_FALSE(may_have_joystick("/nowhere"));
  EXPECT_FALSE(may_have());
  add("event0", "0");    // a power button
  add("event1", "0 0");  // a keyboard
  EXPECT_FALSE(may_have());
  add("event2", "3003f");  // a gamepad
  EXPECT_TRUE(may_have());
}

TEST_F(InputClass, MayHaveAJoystickWhoseAxesAreInTheHigherWord) {
  add("event0", "100000000000000 0");
  EXPECT_TRUE(may_have());
}

}  // namespace
}  // namespace tandem
