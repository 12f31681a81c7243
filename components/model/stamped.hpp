// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tandem {

/// The last value received and its time [s]. The clock may be set back (a simulator or a recording
/// that restarts). Older timestamps then lie in the future and must be discarded, or they would
/// count as fresh once the clock reaches them again.
template <class T>
struct Stamped {
  static constexpr double kNever = -1e9;  // [s]

  T value{};
  double t = kNever;

  /// Whether it was received at most `timeout` [s] ago.
  [[nodiscard]] bool fresh(double now, double timeout) const {
    return t <= now && now - t <= timeout;
  }
  /// Call after the clock was set back to `now`.
  void forget_later_than(double now) {
    if (t > now) t = kNever;
  }
};

}  // namespace tandem
