// SPDX-License-Identifier: Apache-2.0
// A value with the time at which it was received or sent.
#pragma once

#include <limits>

namespace tandem {

/// A value and its time [s], on a clock of the owner's choice.
template <class T>
struct Stamped {
  /// time of a value that has not arrived [s]
  static constexpr double kNever = -std::numeric_limits<double>::infinity();

  T value{};          ///< the latest value
  double t = kNever;  ///< kNever: there is no value yet

  /// Infinite if there is no value yet [s].
  [[nodiscard]] double age(double now) const { return now - t; }
  /// Whether the value is at most `timeout` [s] old. A value of the future is not fresh.
  [[nodiscard]] bool fresh(double now, double timeout) const {
    return t <= now && age(now) <= timeout;
  }
  /// Discards the value, for example after the clock jumped back: its age is unknown then.
  void reset() { *this = {}; }
};

}  // namespace tandem
