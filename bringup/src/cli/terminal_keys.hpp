// SPDX-License-Identifier: Apache-2.0
// Converts the characters of a terminal to a stick that is held as long as a key is held.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tandem {

/// The keys of teleop_twist_keyboard and the arrows. A terminal does not report the release of a
/// key; it repeats a held key after a delay. A key therefore counts as held for kFirst after the
/// first character and for kRepeat after each further one.
///
/// Characters that arrive faster than a keyboard repeats were held back by a stalled connection
/// (ssh). Movement keys are then ignored until none has arrived for kRepeat, because a key may have
/// been held throughout the stall and driving must resume with a new press.
class TerminalKeys {
 public:
  static constexpr double kFirst = 0.6;     // [s] repeats begin after: X11 0.66 s, consoles 0.25 s
  static constexpr double kRepeat = 0.15;   // [s]
  static constexpr double kFastest = 50.0;  // [1/s] fastest repeat of a keyboard
  static constexpr double kAtOnce = 8.0;    // keys that may arrive together without a stall

  enum class Order { kNone, kEmergencyStop, kRelease };
  struct Stick {
    double linear = 0.0, angular = 0.0;  ///< in [−1, 1], forward and left

    bool operator==(const Stick&) const = default;
  };

  /// Processes the characters typed until `now` [s]; returns the last order among them.
  [[nodiscard]] Order type(std::string_view characters, double now);
  /// The stick; empty while no key is held.
  [[nodiscard]] std::optional<Stick> held(double now) const;

  [[nodiscard]] double linear_scale() const { return linear_; }
  [[nodiscard]] double angular_scale() const { return angular_; }

 private:
  void press(char key, double now);
  void watch_backlog(const std::string& keys, double now);

  char key_ = 0;
  double until_ = 0.0;     // [s] key_ counts as held until then
  double read_ = -1e9;     // [s] time of the last call of type()
  double ignored_ = -1e9;  // [s] movement keys are ignored until then
  double linear_ = 0.8, angular_ = 0.8;
};

}  // namespace tandem
