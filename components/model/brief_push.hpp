// SPDX-License-Identifier: Apache-2.0
// In: whether a stick is at rest, sample by sample. Out: whether the rest is meant as one.
#pragma once

namespace tandem {

/// Tells a stick at rest from the pause between two pulses. A person who drives by pulses (sip and
/// puff, a key that is tapped) lets the stick rest after each and does not mean to stop: a rest
/// after a push shorter than kBrief counts only once it has lasted kPause.
class BriefPush {
 public:
  static constexpr double kBrief = 0.8;  ///< [s]
  static constexpr double kPause = 0.4;  ///< [s]

  /// Whether the stick, at rest or not at time t [s], is at rest and is meant to be.
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
  double since_ = -1.0;  // [s]; below 0: nothing was said yet
};

}  // namespace tandem
