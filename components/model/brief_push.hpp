// SPDX-License-Identifier: Apache-2.0
// Decides whether a stick at rest is meant as a stop or is the pause between two pulses.
#pragma once

#include <cmath>

#include "tandem/model/se2.hpp"

namespace tandem {

/// The largest twist [m/s, rad/s] that a hand which lets go of the stick still asks for: it seldom
/// meets the centre of both axes at once.
inline constexpr Twist2 kUnintended{0.02, 0.1};

/// Whether `asked` asks a robot that moves as `measured` to stop. A robot that stands turns and
/// drives as slowly as asked.
[[nodiscard]] inline bool asks_to_stop(const Twist2& asked, const Twist2& measured) {
  constexpr double kDrives = 0.05;  // [m/s]
  if (std::abs(measured.v) < kDrives) return asked == Twist2{};
  return std::abs(asked.v) <= kUnintended.v && std::abs(asked.w) <= kUnintended.w;
}

/// Distinguishes a stick at rest from the pause between two pulses. A person who drives by pulses
/// (sip and puff, a tapped key) releases the stick after each one without meaning to stop: a rest
/// after a push shorter than kBrief counts only once it has lasted kPause.
class BriefPush {
 public:
  static constexpr double kBrief = 0.8;  ///< [s]
  static constexpr double kPause = 0.4;  ///< [s]

  /// Takes a sample at time t [s]; returns whether the stick is at rest and the rest counts.
  [[nodiscard]] bool rests(bool at_rest, double t) {
    if (at_rest != resting_) {
      brief_ = at_rest && since_ >= 0.0 && t >= since_ && t - since_ < kBrief;
      resting_ = at_rest;
      since_ = t;
    }
    return at_rest && (!brief_ || t < since_ || t - since_ >= kPause);
  }

 private:
  bool resting_ = true, brief_ = false;
  double since_ = -1.0;  // [s] start of the current rest or push; below 0: no sample yet
};

}  // namespace tandem
