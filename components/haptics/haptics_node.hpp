// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tandem/haptics/haptics.hpp"
#include "tandem/io/twist_input.hpp"
#include "tandem/model/stamped.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

struct HapticsNodeParams {
  HapticsParams haptics;
  StampParams input;

  template <class Visitor>
  void visit(Visitor&& field) {
    haptics.visit(field);
    input.visit(field);
  }
};

/// cmd_vel_user, safety_filter/status → joy/set_feedback (rumble, 10 Hz while it is not zero).
class HapticsNode {
 public:
  using Params = HapticsNodeParams;

  static constexpr double kPeriod = 0.1;   // [s]
  static constexpr double kSilence = 0.2;  // [s] an input is ignored this long after it was read

  explicit HapticsNode(rt::Node& node);
  [[nodiscard]] static rt::Interface interface();

 private:
  void feel();

  rt::Node& node_;
  rt::Parameters<HapticsNodeParams> params_;
  Haptics haptics_;
  Stamped<Twist2> user_, robot_;  // by the steady clock
  double clearance_ = 0.0;
  double felt_ = 0.0;

  rt::Publisher<sensor_msgs::msg::JoyFeedback> feedback_;
  TwistInput on_user_;
  rt::Subscription on_filter_;
  rt::Timer timer_;
};

}  // namespace tandem
