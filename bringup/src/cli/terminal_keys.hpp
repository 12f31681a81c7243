// SPDX-License-Identifier: Apache-2.0
// In: the characters that a terminal delivers. Out: a stick that is held as long as a key is.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tandem {

/// teleop_twist_keyboard's keys, and the arrows. A terminal never tells that a key was let go: it
/// repeats one that is held, after a delay. A key counts as held for kFirst, then for kRepeat.
///
/// More characters than a keyboard repeats are what a stalled connection (ssh) has kept back. From
/// then on no key counts until none has come for kRepeat: it may have been held all the time.
class TerminalKeys {
 public:
  static constexpr double kFirst = 0.6;     // [s] X11 waits 0.66 s, most consoles 0.25 s
  static constexpr double kRepeat = 0.15;   // [s]
  static constexpr double kFastest = 50.0;  // [1/s] that a keyboard repeats
  static constexpr double kAtOnce = 8.0;    // keys that may come together all the same

  enum class Order { kNone, kEmergencyStop, kRelease };
  struct Stick {
    double linear = 0.0, angular = 0.0;  ///< in [−1, 1], forward and left

    bool operator==(const Stick&) const = default;
  };

  /// Takes what was typed at `now` [s]; what the last order in it is.
  [[nodiscard]] Order type(std::string_view characters, double now);
  /// The stick while a key is held.
  [[nodiscard]] std::optional<Stick> held(double now) const;

  [[nodiscard]] double linear_scale() const { return linear_; }
  [[nodiscard]] double angular_scale() const { return angular_; }

 private:
  void press(char key, double now);
  void watch_backlog(const std::string& keys, double now);

  char key_ = 0;
  double until_ = 0.0;     // [s]
  double read_ = -1e9;     // [s] when keys were last taken
  double ignored_ = -1e9;  // [s] until then moves do not count
  double linear_ = 0.8, angular_ = 0.8;
};

}  // namespace tandem
