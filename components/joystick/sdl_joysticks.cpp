// SPDX-License-Identifier: Apache-2.0
// Joysticks by SDL 2; libtandem-sdl.so. It is loaded when there may be a joystick, because SDL
// brings five megabytes of libraries for windows and sound.
#include <SDL2/SDL.h>

#include <algorithm>
#include <stdexcept>

#include "tandem/joystick/joystick_devices.hpp"

namespace tandem {
namespace {

std::string text(const char* name) { return name == nullptr ? "?" : name; }

class SdlJoystick final : public JoystickDevice {
 public:
  explicit SdlJoystick(int index) : joystick_{SDL_JoystickOpen(index)} {
    if (joystick_ == nullptr || !attached())
      throw std::runtime_error("joystick " + std::to_string(index) +
                               " cannot be opened: " + SDL_GetError());
  }

  [[nodiscard]] bool attached() const override {
    return SDL_JoystickGetAttached(joystick_.get()) == SDL_TRUE;
  }
  [[nodiscard]] std::string name() const override {
    return text(SDL_JoystickName(joystick_.get()));
  }

  void rumble(float intensity, double duration) const override {
    const float share = intensity > 0.0F ? std::min(intensity, 1.0F) : 0.0F;  // NaN: none
    const auto strength = static_cast<Uint16>(65535.0F * share);
    SDL_JoystickRumble(joystick_.get(), strength, strength, static_cast<Uint32>(1000.0 * duration));
  }

  [[nodiscard]] RawJoystick read() const override {
    RawJoystick raw;
    for (int i = 0; i < SDL_JoystickNumAxes(joystick_.get()); ++i)
      raw.axes.push_back(SDL_JoystickGetAxis(joystick_.get(), i));
    for (int i = 0; i < SDL_JoystickNumButtons(joystick_.get()); ++i)
      raw.buttons.push_back(SDL_JoystickGetButton(joystick_.get(), i) != 0);
    for (int i = 0; i < SDL_JoystickNumHats(joystick_.get()); ++i) {
      const auto hat = SDL_JoystickGetHat(joystick_.get(), i);
      raw.hats.push_back({(hat & SDL_HAT_LEFT) != 0, (hat & SDL_HAT_RIGHT) != 0,
                          (hat & SDL_HAT_UP) != 0, (hat & SDL_HAT_DOWN) != 0});
    }
    return raw;
  }

 private:
  struct Close {
    void operator()(SDL_Joystick* joystick) const { SDL_JoystickClose(joystick); }
  };
  std::unique_ptr<SDL_Joystick, Close> joystick_;
};

// SDL counts its users. It must not handle Ctrl-C, and must report events although no window has
// the focus.
class SdlJoysticks final : public JoystickDevices {
 public:
  SdlJoysticks() {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    if (SDL_InitSubSystem(SDL_INIT_JOYSTICK) != 0)
      throw std::runtime_error(std::string{"SDL cannot access joysticks: "} + SDL_GetError());
    SDL_JoystickEventState(SDL_IGNORE);  // states are polled; the event queue is not read
  }
  ~SdlJoysticks() override { SDL_QuitSubSystem(SDL_INIT_JOYSTICK); }
  SdlJoysticks(const SdlJoysticks&) = delete;
  SdlJoysticks& operator=(const SdlJoysticks&) = delete;

  void update() override { SDL_JoystickUpdate(); }

  [[nodiscard]] std::unique_ptr<JoystickDevice> open(const std::string& name, int id) override {
    const int index = name.empty() ? id : index_of(name);
    if (index >= SDL_NumJoysticks()) return nullptr;
    return std::make_unique<SdlJoystick>(index);
  }

 private:
  // The number of joysticks if no name contains `name`.
  static int index_of(const std::string& name) {
    int index = 0;
    const int count = SDL_NumJoysticks();
    while (index < count && text(SDL_JoystickNameForIndex(index)).find(name) == std::string::npos)
      ++index;
    return index;
  }
};

}  // namespace
}  // namespace tandem

// The caller owns the object.
extern "C" __attribute__((visibility("default"))) tandem::JoystickDevices* tandem_joysticks() {
  return new tandem::SdlJoysticks;
}
