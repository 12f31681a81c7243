// SPDX-License-Identifier: Apache-2.0
// In: what a device's axes, buttons and hats are. Out: joy as ROS's joy_node sends it, and when.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tandem/config/params.hpp"

namespace tandem {

struct JoystickParams {
  double deadzone = 0.05;
  double autorepeat_rate = 20.0;
  bool only_held = false;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("deadzone", deadzone, Range{0.0, 0.9}, "[1] part of an axis's way that is rest");
    field("autorepeat_rate", autorepeat_rate, Range{5.0, 1000.0},
          "[Hz] at which an unchanged joystick is sent again; slower would be a release");
    field("only_held", only_held,
          "silent while no button is held, so that others who send joy are not let go");
  }
};

/// A device as the operating system tells: axes in [−32768, 32767], right and down positive.
struct RawJoystick {
  struct Hat {
    bool left = false, right = false, up = false, down = false;
  };
  std::vector<std::int16_t> axes;
  std::vector<bool> buttons;
  std::vector<Hat> hats;
};

/// As sensor_msgs/Joy: axes in [−1, 1], left and up positive, two for each hat behind the others.
struct JoySample {
  std::vector<float> axes;
  std::vector<int> buttons;

  bool operator==(const JoySample&) const = default;
};

/// Turns a device into joy. A button that is down when the device comes counts from its next press
/// on, and a device that goes lets go of everything: no dead-man survives the cable.
class Joystick {
 public:
  /// Throws std::invalid_argument on parameters out of range.
  explicit Joystick(const JoystickParams& params);

  /// `device`: null if none is there. What is to be sent at `now` [s], if anything is.
  [[nodiscard]] std::optional<JoySample> update(const RawJoystick* device, double now);

 private:
  [[nodiscard]] JoySample sample(const RawJoystick& device);
  [[nodiscard]] float scaled(std::int16_t axis) const;

  JoystickParams params_;
  std::vector<bool> stuck_;  // buttons that were down at the start
  std::optional<JoySample> sent_;
  double sent_at_ = 0.0;
};

}  // namespace tandem
