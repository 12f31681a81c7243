// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "tandem/joystick/joystick.hpp"

namespace tandem {

/// A device that is open. To be used by one thread.
class JoystickDevice {
 public:
  virtual ~JoystickDevice() = default;

  /// Whether it is still connected.
  [[nodiscard]] virtual bool attached() const = 0;
  [[nodiscard]] virtual std::string name() const = 0;
  /// The state at the last JoystickDevices::update().
  [[nodiscard]] virtual RawJoystick read() const = 0;
  /// Runs the motors for `duration` [s] at `intensity` in [0, 1]; a device without motors ignores
  /// it.
  virtual void rumble(float intensity, double duration) const = 0;
};

/// The joysticks of this host. To be used by one thread; must outlive its devices.
class JoystickDevices {
 public:
  virtual ~JoystickDevices() = default;

  /// Takes note of new devices, of those that left, and of their states.
  virtual void update() = 0;
  /// Opens the first device whose name contains `name` or, if that is empty, the device with index
  /// `id`. Null if there is none. Throws std::runtime_error if it cannot be opened.
  [[nodiscard]] virtual std::unique_ptr<JoystickDevice> open(const std::string& name, int id) = 0;
};

/// Whether the kernel lists an input device with axes, which may be a joystick. `input_class`: the
/// folder of the kernel's input devices.
[[nodiscard]] bool may_have_joystick(const std::string& input_class = "/sys/class/input");

}  // namespace tandem
