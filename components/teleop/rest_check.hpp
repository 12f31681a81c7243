// SPDX-License-Identifier: Apache-2.0
// Checks that a stick was seen at rest before it may drive.
#pragma once

#include <algorithm>
#include <map>
#include <string>

#include "tandem/model/stamped.hpp"

namespace tandem {

/// A stick may not drive until its sender has been seen at rest. The check starts again when the
/// sender falls silent and, where there is a dead-man button, when the button is pressed with the
/// stick off rest. Before that, a push cannot be told from a stick lying tilted on a table, or from
/// a device that has not reported its axes yet.
class RestCheck {
 public:
  static constexpr double kSenderTimeout = 0.5;  ///< [s] of silence: gone, not late

  /// `timeout`: longest ordinary gap between two samples [s]. `has_deadman`: whether the dead-man
  /// button is used.
  RestCheck(double timeout, bool has_deadman)
      : silence_{std::max(timeout, kSenderTimeout)}, has_deadman_{has_deadman} {}

  /// Takes a sample from `sender` at time t [s]; returns whether it may drive. `at_rest`: the stick
  /// is at rest; `deadman`: the button is held.
  [[nodiscard]] bool frees(const std::string& sender, bool deadman, bool at_rest, double t) {
    forget_silent(t);
    Stamped<Sender>& known = senders_[sender];
    const bool pressed = has_deadman_ && deadman && !known.value.deadman;
    known = {{at_rest || (known.value.rested && !pressed), deadman}, t};
    return known.value.rested;
  }
  /// Call for a sample that arrived too late to be used: the sender is not silent.
  void keep(const std::string& sender, double t) {
    forget_silent(t);
    if (const auto known = senders_.find(sender); known != senders_.end()) known->second.t = t;
  }
  /// Call when the person at this sender has left: the next person must be seen at rest.
  void forget(const std::string& sender) { senders_.erase(sender); }

 private:
  struct Sender {
    bool rested = false, deadman = false;
  };

  void forget_silent(double t) {
    std::erase_if(senders_, [&](const auto& known) { return !known.second.fresh(t, silence_); });
  }

  double silence_;
  bool has_deadman_;
  std::map<std::string, Stamped<Sender>> senders_;  // by their last sample; none is silent
};

}  // namespace tandem
