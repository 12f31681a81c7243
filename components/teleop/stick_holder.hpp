// SPDX-License-Identifier: Apache-2.0
// In: sticks of several senders on one topic. Out: whose counts.
#pragma once

#include <string>

namespace tandem {

/// One of several sticks drives: the first that is held, until it is let go or silent for `timeout`
/// [s]. Meanwhile what others say counts for nothing, least of all that theirs is not held: a
/// gamepad that lies on the table does not stop the person at the page.
class StickHolder {
 public:
  explicit StickHolder(double timeout) : timeout_{timeout} {}

  /// Whether a stick that `sender` says is `held` counts at time t [s].
  [[nodiscard]] bool counts(const std::string& sender, bool held, double t) {
    const bool others = held_ && sender != sender_ && t - t_ <= timeout_ && t >= t_;
    if (others) return false;
    held_ = held;
    sender_ = sender;
    t_ = t;
    return true;
  }

 private:
  double timeout_;
  bool held_ = false;
  std::string sender_;
  double t_ = 0.0;
};

}  // namespace tandem
