// SPDX-License-Identifier: Apache-2.0
// Selects the active joystick among several senders on one topic.
#pragma once

#include <string>

#include "tandem/model/stamped.hpp"

namespace tandem {

/// One of several sticks drives: the first that is held, until it is let go, or until it is silent
/// for `timeout` [s] while another is held. Samples of the others are ignored until then. In
/// particular, an idle gamepad neither stops the person driving from the web page nor counts as
/// that person letting go when the page's connection is lost.
class StickHolder {
 public:
  explicit StickHolder(double timeout) : timeout_{timeout} {}

  /// Takes a sample from `sender` at time t [s]; returns whether it counts. `held`: the stick is
  /// held.
  [[nodiscard]] bool counts(const std::string& sender, bool held, double t) {
    const bool fresh = sender_.fresh(t, timeout_);
    if (held_ && sender != sender_.value && (fresh || !held)) return false;
    held_ = held;
    sender_ = {sender, t};
    return true;
  }

 private:
  double timeout_;
  bool held_ = false;
  Stamped<std::string> sender_;  // of the last sample that counted
};

}  // namespace tandem
