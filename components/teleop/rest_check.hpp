// SPDX-License-Identifier: Apache-2.0
// Tells whether a stick was seen at rest before it drives.
#pragma once

#include <algorithm>
#include <map>
#include <string>

namespace tandem {

/// A stick drives nothing until its sender has been seen at rest, since the sender appeared or fell
/// silent and, where there is a dead-man button, since this was last pressed with the stick off
/// rest. Until then nobody can tell a push from a stick that lies on the table, or from a device
/// that has not reported its axes yet.
class RestCheck {
 public:
  static constexpr double kGone = 0.5;  ///< [s] of silence after which a sender is gone, not late

  /// `timeout`: silence that is ordinary between two samples [s]. `has_deadman`: the dead-man
  /// counts.
  RestCheck(double timeout, bool has_deadman)
      : silence_{std::max(timeout, kGone)}, has_deadman_{has_deadman} {}

  /// Whether what `sender` says at time t [s] may drive. `at_rest`: the stick is; `deadman`: the
  /// button is held.
  [[nodiscard]] bool frees(const std::string& sender, bool deadman, bool at_rest, double t) {
    forget_silent(t);
    Sender& known = senders_[sender];
    const bool pressed = has_deadman_ && deadman && !known.deadman;
    known = {at_rest || (known.rested && !pressed), deadman, t};
    return known.rested;
  }
  /// A sample arrived too late to count: the sender has not fallen silent.
  void keep(const std::string& sender, double t) {
    forget_silent(t);
    if (const auto known = senders_.find(sender); known != senders_.end()) known->second.t = t;
  }
  /// The person at this sender is gone: the next one has to be seen at rest.
  void forget(const std::string& sender) { senders_.erase(sender); }

 private:
  struct Sender {
    bool rested = false, deadman = false;
    double t = 0.0;  // [s] of its last sample
  };

  void forget_silent(double t) {
    std::erase_if(senders_, [&](const auto& known) {
      return t - known.second.t > silence_ || t < known.second.t;
    });
  }

  double silence_;
  bool has_deadman_;
  std::map<std::string, Sender> senders_;  // those that are not silent
};

}  // namespace tandem
