// SPDX-License-Identifier: Apache-2.0
// Tests the joystick component over real DDS with a virtual SDL device.
#include <SDL2/SDL.h>

#include <atomic>
#include <memory>

#include "system/one_component.hpp"

namespace tandem::test {
namespace {

// SDL's virtual joystick, plugged in during this object's lifetime.
class VirtualJoystick {
 public:
  VirtualJoystick() {
    SDL_VirtualJoystickDesc desc{};
    desc.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
    desc.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
    desc.naxes = 2;
    desc.nbuttons = 3;
    desc.name = "Virtual stick of a test";
    desc.userdata = this;
    desc.Rumble = [](void* self, Uint16 low, Uint16) {
      static_cast<VirtualJoystick*>(self)->rumble_ = low;
      return 0;
    };
    index_ = SDL_JoystickAttachVirtualEx(&desc);
    if (index_ >= 0) joystick_ = SDL_JoystickOpen(index_);
    if (joystick_ != nullptr) id_ = SDL_JoystickInstanceID(joystick_);
  }
  ~VirtualJoystick() {
    if (joystick_ != nullptr) SDL_JoystickClose(joystick_);
    for (int i = 0; i < SDL_NumJoysticks(); ++i)  // others may have gone since
      if (id_ >= 0 && SDL_JoystickGetDeviceInstanceID(i) == id_) SDL_JoystickDetachVirtual(i);
  }
  VirtualJoystick(const VirtualJoystick&) = delete;
  VirtualJoystick& operator=(const VirtualJoystick&) = delete;

  [[nodiscard]] bool exists() const { return joystick_ != nullptr; }
  [[nodiscard]] int rumble() const { return rumble_; }
  void axis(int number, std::int16_t value) const {
    SDL_JoystickSetVirtualAxis(joystick_, number, value);
  }
  void button(int number, bool down) const {
    SDL_JoystickSetVirtualButton(joystick_, number, down ? 1 : 0);
  }

 private:
  int index_ = -1;
  SDL_JoystickID id_ = -1;
  std::atomic<int> rumble_ = 0;
  SDL_Joystick* joystick_ = nullptr;
};

class JoystickOverDds : public OneComponent {
 protected:
  JoystickOverDds() {
    setenv("SDL_JOYSTICK_DEVICE", "/dev/null", 1);  // a reason to load SDL
    SDL_InitSubSystem(SDL_INIT_JOYSTICK);
    joy_ = node_.create_subscription(topics::joy, [this](const auto& msg) {
      last_ = msg;
      ++count_;
    });
  }
  ~JoystickOverDds() override {
    SDL_QuitSubSystem(SDL_INIT_JOYSTICK);
    unsetenv("SDL_JOYSTICK_DEVICE");
  }

  [[nodiscard]] bool pressed() const { return !last_.buttons().empty() && last_.buttons()[0] == 1; }

  rt::Subscription joy_;
  sensor_msgs::msg::Joy last_;
  int count_ = 0;
};

TEST_F(JoystickOverDds, PublishesAPluggedInDeviceAndReleasesWhenItIsUnplugged) {
  const auto component = load("joystick", {{"device_name", "stick of a test"}});
  {
    const VirtualJoystick device;
    if (!device.exists()) GTEST_SKIP() << "NOT TESTED: " << SDL_GetError();
    ASSERT_TRUE(wait_until([&] { return count_ > 3; }));  // it repeats itself
    EXPECT_EQ(last_.axes().size(), 2U);
    EXPECT_EQ(last_.header().frame_id(), "joy");
    device.button(0, true);
    device.axis(1, -32768);
    ASSERT_TRUE(wait_until([&] { return pressed() && last_.axes()[1] == 1.0F; }));
    const auto feedback = node_.create_publisher(topics::joy_feedback);
    sensor_msgs::msg::JoyFeedback half;
    half.type(sensor_msgs::msg::JoyFeedback_Constants::TYPE_RUMBLE);
    half.intensity(0.5F);
    EXPECT_TRUE(wait_until([&] {
      feedback.publish(half);
      return device.rumble() == 32767;
    }));
    EXPECT_TRUE(wait_until([&] { return device.rumble() == 0; }));  // it is not told again
  }
  ASSERT_TRUE(wait_until([&] { return !pressed() && last_.axes()[1] == 0.0F; }));
  const VirtualJoystick again;
  const int before = count_;
  ASSERT_TRUE(wait_until([&] { return count_ > before; }));
  EXPECT_FALSE(pressed());
}

TEST_F(JoystickOverDds, DoesNotHandTheHoldFromOneDeviceToTheNext) {
  const auto component = load("joystick", {{"device_name", "stick of a test"}});
  auto first = std::make_unique<VirtualJoystick>();
  if (!first->exists()) GTEST_SKIP() << "NOT TESTED: " << SDL_GetError();
  ASSERT_TRUE(wait_until([&] { return count_ > 3; }));
  first->button(0, true);
  ASSERT_TRUE(wait_until([&] { return pressed(); }));
  const VirtualJoystick second;
  second.button(0, true);
  second.axis(0, 32767);
  first.reset();
  ASSERT_TRUE(wait_until([&] { return !pressed(); }));
  ASSERT_TRUE(wait_until([&] { return last_.axes()[0] == -1.0F; }));  // the second joystick is read
  EXPECT_FALSE(pressed());
  second.button(0, false);
  const int before = count_;
  ASSERT_TRUE(wait_until([&] { return count_ > before + 2; }));
  second.button(0, true);
  EXPECT_TRUE(wait_until([&] { return pressed(); }));
}

}  // namespace
}  // namespace tandem::test
