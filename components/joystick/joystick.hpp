// SPDX-License-Identifier: Apache-2.0
// Converts the raw state of a joystick device to Joy messages as ROS's joy_node sends them, and
// decides when to send them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tandem/config/params.hpp"

namespace tandem {

/// Dead zone and repetition of a gamepad.
struct JoystickParams {
  double deadzone = 0.05;
  double autorepeat_rate = 20.0;
  bool only_held = false;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("deadzone", deadzone, Range{0.0, 0.9},
          "[1] fraction of an axis's travel that counts as rest");
    field("autorepeat_rate", autorepeat_rate, Range{5.0, 1000.0},
          "[Hz] rate at which an unchanged joystick is published again; a lower rate would count "
          "as a release");
    field("only_held", only_held,
          "true: nothing is published while no button is held, so that other publishers of joy are "
          "not released");
  }
};

/// Device state as the operating system reports it: axes in [−32768, 32767], right and down
/// positive.
struct RawJoystick {
  /// A directional pad.
  struct Hat {
    bool left = false, right = false, up = false, down = false;  ///< pressed that way
  };
  std::vector<std::int16_t> axes;  ///< in the device's order
  std::vector<bool> buttons;       ///< true: pressed
  std::vector<Hat> hats;           ///< in the device's order
};

/// As sensor_msgs/Joy: axes in [−1, 1], left and up positive; each hat adds two axes after the
/// others.
struct JoySample {
  std::vector<float> axes;   ///< in [−1, 1]
  std::vector<int> buttons;  ///< 1: pressed

  bool operator==(const JoySample&) const = default;
};

/// Converts device states to Joy samples. A button that is down when the device is connected counts
/// only from its next press, and all buttons are released when the device is disconnected, so a
/// held dead-man ends when the cable is pulled.
class Joystick {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  explicit Joystick(const JoystickParams& params);

  /// Takes the device state (`device`; null if there is none) at `now` [s] and returns the sample
  /// to send, or nullopt.
  [[nodiscard]] std::optional<JoySample> update(const RawJoystick* device, double now);

 private:
  [[nodiscard]] JoySample sample(const RawJoystick& device);
  [[nodiscard]] float scaled(std::int16_t axis) const;

  JoystickParams params_;
  std::vector<bool> stuck_;  // buttons down since the device was connected
  std::optional<JoySample> sent_;
  double sent_at_ = 0.0;
};

}  // namespace tandem
