// SPDX-License-Identifier: Apache-2.0
#include "tandem/joystick/joystick_node.hpp"

#include <cstdlib>
#include <exception>
#include <utility>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"
#include "tandem/runtime/extension.hpp"

namespace tandem {
namespace {

// Whether to load SDL; its variable names further devices.
bool may_have_device() {
  return may_have_joystick() || std::getenv("SDL_JOYSTICK_DEVICE") != nullptr;
}

std::unique_ptr<JoystickDevices> load_devices() {
  void* made = rt::function_of_extension("sdl", "tandem_joysticks");
  return std::unique_ptr<JoystickDevices>{reinterpret_cast<JoystickDevices* (*)()>(made)()};
}

}  // namespace

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
      joy_{node.create_publisher(topics::joy)} {
  feedback_ = node.create_subscription(topics::joy_feedback, [this](const auto& msg) {
    const bool rumbles = msg.type() == sensor_msgs::msg::JoyFeedback_Constants::TYPE_RUMBLE;
    if (device_ && rumbles) device_->rumble(msg.intensity(), kRumble);
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
  if (devices_) devices_->update();
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
  try {
    open();
  } catch (const std::exception& error) {
    node_.log().warn_every(10.0, "{}", error.what());
  }
}

void JoystickNode::open() {
  if (!devices_ && may_have_device()) devices_ = load_devices();
  if (!devices_) return;
  device_ = devices_->open(params_->device_name, params_->device_id);
  if (device_) node_.log().info("joystick: {}", device_->name());
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::JoystickNode, "joystick")
