// SPDX-License-Identifier: Apache-2.0
// Detects a joystick whose messages come too seldom for joy_timeout.
#pragma once

#include <optional>

#include "tandem/model/stamped.hpp"

namespace tandem {

/// A stick whose messages come less often than every `joy_timeout` [s] counts as let go between any
/// two of them, so the robot stutters. Distinguishes this from a stick that fell silent.
class JoyRhythm {
 public:
  static constexpr int kGaps = 5;          ///< consecutive gaps that are too long
  static constexpr double kSilence = 1.0;  ///< [s] a longer gap is silence, not a slow rate

  explicit JoyRhythm(double joy_timeout) : joy_timeout_{joy_timeout} {}

  /// Takes a message of the driving stick at t [s]. Returns the gap before it [s] once kGaps in a
  /// row were too long.
  std::optional<double> on_message(bool held, double t) {
    const double gap = held_.age(t);
    const bool too_long = held && held_.value && gap > joy_timeout_ && gap < kSilence;
    gaps_ = too_long ? gaps_ + 1 : 0;
    held_ = {held, t};
    return gaps_ >= kGaps ? std::optional{gap} : std::nullopt;
  }

 private:
  double joy_timeout_;
  Stamped<bool> held_;  // in the last message
  int gaps_ = 0;
};

}  // namespace tandem
