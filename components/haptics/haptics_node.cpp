// SPDX-License-Identifier: Apache-2.0
#include "haptics/haptics_node.hpp"

#include "convert.hpp"
#include "runtime/component.hpp"
#include "topics.hpp"

namespace tandem {

HapticsNode::HapticsNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<HapticsParams>()},
      haptics_{*params_},
      feedback_{node.create_publisher(topics::joy_feedback)} {
  on_user_ =
      node.create_subscription(topics::cmd_vel_user, topics::kUserInput, [this](const auto& msg) {
        const auto twist = from_msg(msg);
        if (!twist) return;
        user_ = *twist;
        user_at_ = node_.steady_now();
      });
  on_filter_ = node.create_subscription(topics::filter_status, [this](const auto& msg) {
    const auto twist = from_msg(msg.passed());
    if (!twist) return;
    robot_ = *twist;
    clearance_ = msg.clearance();
    filter_at_ = node_.steady_now();
  });
  timer_ = node.create_wall_timer(kPeriod, [this] { feel(); });
}

void HapticsNode::feel() {
  const double now = node_.steady_now();
  const bool pushes = now - user_at_ <= kSilence && now - filter_at_ <= kSilence;
  const double before = felt_;
  felt_ = haptics_.feel(pushes ? std::optional{user_} : std::nullopt, robot_, clearance_, kPeriod);
  if (felt_ == 0.0 && before == 0.0) return;  // silence is rest
  sensor_msgs::msg::JoyFeedback msg;
  msg.type(sensor_msgs::msg::JoyFeedback_Constants::TYPE_RUMBLE);
  msg.intensity(static_cast<float>(felt_));
  feedback_.publish(msg);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::HapticsNode, "haptics")
