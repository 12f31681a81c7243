// SPDX-License-Identifier: Apache-2.0
// Checks whether a message's stamp is recent.
#pragma once

#include <functional>
#include <string>

#include "tandem/runtime/node.hpp"

namespace tandem {

struct StampParams {
  double max_stamp_age = 0.5;

  template <class Visitor>
  void visit(Visitor&& field) {
    field(
        "max_stamp_age", max_stamp_age, Range{0.0, 60.0},
        "[s] that the stamp of a person's input or of a TwistStamped may differ from now, else it "
        "is dropped; 0: any");
  }
};

/// Rejects commands that a slow link has delayed, by their stamps. A zero stamp counts as no stamp.
class StampCheck {
 public:
  StampCheck(rt::Node& node, std::string topic, const StampParams& params);

  /// Stamps are of this time [s], for a node that makes it; else of the node's own.
  void judge_by(std::function<double()> now) { now_ = std::move(now); }

  /// Whether the stamp is at most `max_stamp_age` off; warns if not. Off either way: a clock that
  /// runs ahead would hide how old a message is. The computer's time is as good as a simulation's:
  /// a joystick's driver knows nothing of the simulation.
  [[nodiscard]] bool in_time(const builtin_interfaces::msg::Time& stamp) const;

 private:
  rt::Node& node_;
  std::string topic_;
  double max_age_;  // [s]
  std::function<double()> now_;
};

}  // namespace tandem
