// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "haptics/haptics.hpp"
#include "runtime/node.hpp"

namespace tandem {

/// cmd_vel_user, safety_filter/status → joy/set_feedback (rumble, 10 Hz while there is any).
class HapticsNode {
 public:
  static constexpr double kPeriod = 0.1;   // [s]
  static constexpr double kSilence = 0.2;  // [s] of an input: it counts no more

  explicit HapticsNode(rt::Node& node);

 private:
  void feel();

  rt::Node& node_;
  rt::Parameters<HapticsParams> params_;
  Haptics haptics_;
  Twist2 user_, robot_;
  double clearance_ = 0.0;
  double user_at_ = -1e9, filter_at_ = -1e9;  // [s] steady
  double felt_ = 0.0;

  rt::Publisher<sensor_msgs::msg::JoyFeedback> feedback_;
  rt::Subscription on_user_, on_filter_;
  rt::Timer timer_;
};

}  // namespace tandem
