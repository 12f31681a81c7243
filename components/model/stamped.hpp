// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tandem {

/// The last value that was heard, and when [s], on a clock that may be set back (a simulator or a
/// recording that starts again): what was heard later than now is of no known age, and would be as
/// good as new when the clock comes there again.
template <class T>
struct Stamped {
  static constexpr double kNever = -1e9;  // [s]

  T value{};
  double t = kNever;

  /// Stamped at most `timeout` [s] ago.
  [[nodiscard]] bool fresh(double now, double timeout) const {
    return t <= now && now - t <= timeout;
  }
  /// The clock was set back to `now`.
  void forget_later_than(double now) {
    if (t > now) t = kNever;
  }
};

}  // namespace tandem
