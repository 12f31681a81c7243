// SPDX-License-Identifier: Apache-2.0
// Finds a joystick that speaks too seldom.
#pragma once

#include <optional>

namespace tandem {

/// A stick whose messages come less often than every `joy_timeout` [s] counts as let go between any
/// two of them: the robot stutters. Tells that from a stick that fell silent.
class JoyRhythm {
 public:
  static constexpr int kGaps = 5;          ///< too long ones in a row
  static constexpr double kSilence = 1.0;  ///< [s] a gap of more is no rhythm

  explicit JoyRhythm(double joy_timeout) : joy_timeout_{joy_timeout} {}

  /// A message at t [s] of the stick that drives. The gap before it, if it is one too many.
  std::optional<double> on_message(bool held, double t) {
    const double gap = t - t_;
    const bool too_long = held && held_ && gap > joy_timeout_ && gap < kSilence;
    gaps_ = too_long ? gaps_ + 1 : 0;
    held_ = held;
    t_ = t;
    return gaps_ >= kGaps ? std::optional{gap} : std::nullopt;
  }

 private:
  double joy_timeout_;
  double t_ = 0.0;
  bool held_ = false;
  int gaps_ = 0;
};

}  // namespace tandem
