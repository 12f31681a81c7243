// SPDX-License-Identifier: Apache-2.0
// Limits on the messages and the work of one client. Times are seconds on one monotonic clock.
#pragma once

#include <algorithm>

namespace tandem {

/// A token bucket: allows `rate` units per second, at most `burst` at once.
class RateLimit {
 public:
  RateLimit(double rate, double burst, double now)
      : rate_{rate}, burst_{burst}, left_{burst}, last_{now} {}

  /// Whether one more unit is allowed; if so, it is counted.
  [[nodiscard]] bool allows(double now) {
    refill(now);
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  void refill(double now) {
    left_ = std::min(burst_, left_ + rate_ * std::max(0.0, now - last_));
    last_ = now;
  }

  double rate_, burst_, left_, last_;
};

/// Budget of work [s] that one client may cause: kShare of each second, accumulated up to kBurst.
/// Work is charged after it is done, so the balance can become negative; the client then waits
/// until it is positive again. The debt never exceeds kMaxDebt.
class ClientBudget {
 public:
  static constexpr double kShare = 0.05;
  static constexpr double kBurst = 0.5;    // [s]
  static constexpr double kMaxDebt = 2.0;  // [s]

  /// A new client starts with half of the burst, so that reconnecting gains nothing.
  explicit ClientBudget(double now) : left_{0.5 * kBurst}, last_{now} {}

  void charge(double work, double now) { left_ = std::max(-kMaxDebt, left(now) - work); }
  /// Remaining work [s]; negative: debt.
  [[nodiscard]] double left(double now) {
    left_ = std::min(kBurst, left_ + kShare * std::max(0.0, now - last_));
    last_ = now;
    return left_;
  }

 private:
  double left_, last_;
};

}  // namespace tandem
