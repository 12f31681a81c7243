// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "tandem/joystick/joystick.hpp"
#include "tandem/joystick/joystick_devices.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct JoystickNodeParams {
  JoystickParams joystick;
  int device_id = 0;
  std::string device_name;

  template <class Visitor>
  void visit(Visitor&& field) {
    joystick.visit(field);
    field("device_id", device_id, Range{0, 63},
          "index of the device; ignored when device_name is given");
    field("device_name", device_name,
          "part of the device's name; empty: device_id selects the device");
  }
};

/// A joystick or gamepad (SDL 2) → joy, and joy/set_feedback → its rumble. Devices may be connected
/// and disconnected at any time. SDL is loaded once there may be a device.
class JoystickNode {
 public:
  using Params = JoystickNodeParams;

  static constexpr double kPoll = 0.005;      // [s] between readings of the device
  static constexpr double kPollPeriod = 0.5;  // [s] between searches for a device
  static constexpr double kRumble = 0.3;      // [s] duration of the rumble unless it is renewed

  explicit JoystickNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void poll();
  void look();
  void open();
  void poll_every(double period);

  rt::Node& node_;
  rt::Parameters<JoystickNodeParams> params_;
  Joystick joystick_;
  std::unique_ptr<JoystickDevices> devices_;  // null until there may be one
  std::unique_ptr<JoystickDevice> device_;    // null while there is none
  double period_ = 0.0;                       // of timer_ [s]

  rt::Publisher<sensor_msgs::msg::Joy> joy_;
  rt::Subscription feedback_;
  rt::Timer timer_;
};

}  // namespace tandem
