// SPDX-License-Identifier: Apache-2.0
// Selects the active joystick among several senders on one topic.
#pragma once

#include <string>

namespace tandem {

/// One of several sticks drives: the first that is held, until it is let go, or is silent for
/// `timeout` [s] while another one is held. What the others send is ignored until then. In
/// particular, a gamepad that lies on the table neither stops the person at the page nor shows,
/// when the page's connection is lost, that the person has let go.
class StickHolder {
 public:
  explicit StickHolder(double timeout) : timeout_{timeout} {}

  /// Whether a stick that `sender` says is `held` counts at time t [s].
  [[nodiscard]] bool counts(const std::string& sender, bool held, double t) {
    const bool fresh = t - t_ <= timeout_ && t >= t_;
    if (held_ && sender != sender_ && (fresh || !held)) return false;
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
