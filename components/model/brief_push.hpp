// SPDX-License-Identifier: Apache-2.0
// Decides whether a stick at rest is meant as a stop or is the pause between two pulses.
#pragma once

namespace tandem {

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
