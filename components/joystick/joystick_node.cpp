// SPDX-License-Identifier: Apache-2.0
#include "tandem/joystick/joystick_node.hpp"

#include <SDL2/SDL.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

std::string text(const char* name) { return name == nullptr ? "?" : name; }

// SDL counts its users. It must not handle Ctrl-C, and must report events although no window has
// the focus.
std::shared_ptr<void> start_sdl() {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
  if (SDL_InitSubSystem(SDL_INIT_JOYSTICK) != 0)
    throw std::runtime_error(std::string{"SDL cannot access joysticks: "} + SDL_GetError());
  SDL_JoystickEventState(SDL_IGNORE);  // states are polled; the event queue is not read
  static int token = 0;
  return {&token, [](void*) { SDL_QuitSubSystem(SDL_INIT_JOYSTICK); }};
}

// Index of the device that the parameters select; −1: not present.
int find_device(const JoystickNodeParams& params) {
  const int count = SDL_NumJoysticks();
  if (params.device_name.empty()) return params.device_id < count ? params.device_id : -1;
  for (int i = 0; i < count; ++i)
    if (text(SDL_JoystickNameForIndex(i)).find(params.device_name) != std::string::npos) return i;
  return -1;
}

}  // namespace

class JoystickNode::Device {
 public:
  explicit Device(int index) : joystick_{SDL_JoystickOpen(index)} {}
  ~Device() {
    if (joystick_ != nullptr) SDL_JoystickClose(joystick_);
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  [[nodiscard]] bool attached() const {
    return joystick_ != nullptr && SDL_JoystickGetAttached(joystick_) == SDL_TRUE;
  }
  [[nodiscard]] std::string name() const { return text(SDL_JoystickName(joystick_)); }

  /// `intensity` in [0, 1]; a device without motors ignores it.
  void rumble(float intensity) const {
    const float share = intensity > 0.0F ? std::min(intensity, 1.0F) : 0.0F;  // NaN: none
    const auto strength = static_cast<Uint16>(65535.0F * share);
    SDL_JoystickRumble(joystick_, strength, strength, kRumble);
  }

  [[nodiscard]] RawJoystick read() const {
    RawJoystick raw;
    for (int i = 0; i < SDL_JoystickNumAxes(joystick_); ++i)
      raw.axes.push_back(SDL_JoystickGetAxis(joystick_, i));
    for (int i = 0; i < SDL_JoystickNumButtons(joystick_); ++i)
      raw.buttons.push_back(SDL_JoystickGetButton(joystick_, i) != 0);
    for (int i = 0; i < SDL_JoystickNumHats(joystick_); ++i) {
      const auto hat = SDL_JoystickGetHat(joystick_, i);
      raw.hats.push_back({(hat & SDL_HAT_LEFT) != 0, (hat & SDL_HAT_RIGHT) != 0,
                          (hat & SDL_HAT_UP) != 0, (hat & SDL_HAT_DOWN) != 0});
    }
    return raw;
  }

 private:
  SDL_Joystick* joystick_;
};

rt::Interface JoystickNode::interface() {
  return {.subscribes = {topics::joy_feedback},
          .publishes = {topics::joy},
          .other_input = "a joystick or gamepad",
          .other_output = "its rumble"};
}

JoystickNode::JoystickNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      joystick_{params_->joystick},
      sdl_{start_sdl()},
      joy_{node.create_publisher(topics::joy)} {
  feedback_ = node.create_subscription(topics::joy_feedback, [this](const auto& msg) {
    const bool rumbles = msg.type() == sensor_msgs::msg::JoyFeedback_Constants::TYPE_RUMBLE;
    if (device_ && rumbles) device_->rumble(msg.intensity());
  });
  look();
  if (!device_) node.log().info("no joystick found; waiting for one");
  poll_every(device_ ? kPoll : kPollPeriod);
}

void JoystickNode::poll_every(double period) {
  if (std::exchange(period_, period) != period)
    timer_ = node_.create_wall_timer(period, [this] { poll(); });
}

void JoystickNode::poll() {
  SDL_JoystickUpdate();
  if (!device_) {
    look();
  } else if (!device_->attached()) {
    node_.log().warn("the joystick was disconnected");
    device_.reset();  // the next poll searches, so that a release is sent first
  }
  poll_every(device_ ? kPoll : kPollPeriod);
  const auto raw = device_ ? std::optional{device_->read()} : std::nullopt;
  const auto sample = joystick_.update(raw ? &*raw : nullptr, node_.steady_now());
  if (!sample) return;
  sensor_msgs::msg::Joy msg;
  msg.header().stamp(node_.stamp());
  msg.header().frame_id("joy");
  msg.axes(sample->axes);
  msg.buttons().assign(sample->buttons.begin(), sample->buttons.end());
  joy_.publish(msg);
}

void JoystickNode::look() {
  const int index = find_device(*params_);
  if (index < 0) return;
  auto device = std::make_shared<Device>(index);
  if (!device->attached()) {
    node_.log().warn_every(10.0, "joystick {} cannot be opened: {}", index, SDL_GetError());
    return;
  }
  device_ = std::move(device);
  node_.log().info("joystick: {}", device_->name());
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::JoystickNode, "joystick")
