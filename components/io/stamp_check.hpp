// SPDX-License-Identifier: Apache-2.0
// Checks whether a message's timestamp is recent.
#pragma once

#include <functional>
#include <string>

#include "tandem/runtime/node.hpp"

namespace tandem {

/// How old a stamped command may be.
struct StampParams {
  double max_stamp_age = 0.5;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("max_stamp_age", max_stamp_age, Range{0.0, 60.0},
          "[s] maximum difference between the present time and the stamp of a person's input or of "
          "a TwistStamped; messages beyond it are dropped; 0: no limit");
  }
};

/// Rejects commands that a slow link delayed, by their timestamps. A zero timestamp is not checked.
class StampCheck {
 public:
  /// `node` must outlive this. `topic`: its name in warnings.
  StampCheck(rt::Node& node, std::string topic, const StampParams& params);

  /// Compares timestamps with `now` [s] instead of the node's clock, for a node that generates
  /// time.
  void check_by(std::function<double()> now) { now_ = std::move(now); }

  /// Whether the timestamp differs from now by at most `max_stamp_age`; logs a warning if not.
  /// Future timestamps are rejected too, because a clock that runs ahead would hide a message's
  /// age. System time is accepted besides simulation time, because joystick drivers do not use the
  /// latter.
  [[nodiscard]] bool in_time(const builtin_interfaces::msg::Time& stamp) const;

 private:
  rt::Node& node_;
  std::string topic_;
  double max_age_;  // [s]
  std::function<double()> now_;
};

}  // namespace tandem
