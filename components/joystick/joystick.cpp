// SPDX-License-Identifier: Apache-2.0
#include "tandem/joystick/joystick.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tandem/model/dead_zone.hpp"

namespace tandem {

Joystick::Joystick(const JoystickParams& params) : params_{params} { check(params_); }

std::optional<JoySample> Joystick::update(const RawJoystick* device, double now) {
  if (device == nullptr) {
    auto last = std::exchange(sent_, std::nullopt);
    if (!last) return std::nullopt;
    std::fill(last->axes.begin(), last->axes.end(), 0.0F);
    std::fill(last->buttons.begin(), last->buttons.end(), 0);
    return last;
  }
  if (!sent_) stuck_ = device->buttons;
  JoySample next = sample(*device);
  const auto is_held = [](const JoySample& s) {
    return std::any_of(s.buttons.begin(), s.buttons.end(), [](int b) { return b != 0; });
  };
  // The first sample and the one that releases the buttons are sent all the same.
  if (params_.only_held && sent_ && !is_held(*sent_) && !is_held(next)) return std::nullopt;
  if (sent_ == next && now - sent_at_ < 1.0 / params_.autorepeat_rate) return std::nullopt;
  sent_at_ = now;
  return sent_ = std::move(next);
}

JoySample Joystick::sample(const RawJoystick& device) {
  JoySample sample;
  for (const auto axis : device.axes) sample.axes.push_back(scaled(axis));
  for (const auto& hat : device.hats) {
    sample.axes.push_back(static_cast<float>(int{hat.left} - int{hat.right}));
    sample.axes.push_back(static_cast<float>(int{hat.up} - int{hat.down}));
  }
  stuck_.resize(device.buttons.size());
  for (std::size_t i = 0; i < device.buttons.size(); ++i) {
    stuck_[i] = stuck_[i] && device.buttons[i];
    sample.buttons.push_back(device.buttons[i] && !stuck_[i] ? 1 : 0);
  }
  return sample;
}

// Zero within the dead zone, then linear to ±1.
float Joystick::scaled(std::int16_t axis) const {
  return static_cast<float>(0.0 - beyond_dead_zone(axis / 32767.0, params_.deadzone));
}

}  // namespace tandem
