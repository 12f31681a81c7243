// SPDX-License-Identifier: Apache-2.0
#include "tandem/haptics/haptics_node.hpp"

#include "tandem/io/conversions.hpp"
#include "tandem/io/topics.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {

rt::Interface HapticsNode::interface() {
  return TwistInput::interface(topics::cmd_vel_user, topics::kUserInput) +
         rt::Interface{.subscribes = {topics::filter_status}, .publishes = {topics::joy_feedback}};
}

HapticsNode::HapticsNode(rt::Node& node)
    : node_{node},
      params_{node.declare_parameters<Params>()},
      haptics_{params_->haptics},
      feedback_{node.create_publisher(topics::joy_feedback)},
      on_user_{node, topics::cmd_vel_user, topics::kUserInput, params_->input,
               [this](const Twist2& twist) {
                 user_ = {twist, node_.steady_now()};
               }} {
  on_filter_ = node.create_subscription(topics::filter_status, [this](const auto& msg) {
    const auto twist = from_msg(msg.passed());
    if (!twist) return;
    robot_ = {*twist, node_.steady_now()};
    clearance_ = msg.clearance();
  });
  on_filter_.may_wait(kPeriod);  // it is read before feel() is called
  timer_ = node.create_wall_timer(kPeriod, [this] { feel(); });
}

void HapticsNode::feel() {
  const double now = node_.steady_now();
  const bool pushes = user_.fresh(now, kSilence) && robot_.fresh(now, kSilence);
  const double before = felt_;
  felt_ = haptics_.feel(pushes ? std::optional{user_.value} : std::nullopt, robot_.value,
                        clearance_, kPeriod);
  if (felt_ == 0.0 && before == 0.0) return;  // no message means no rumble
  sensor_msgs::msg::JoyFeedback msg;
  msg.type(sensor_msgs::msg::JoyFeedback_Constants::TYPE_RUMBLE);
  msg.intensity(static_cast<float>(felt_));
  feedback_.publish(msg);
}

}  // namespace tandem

TANDEM_COMPONENT(tandem::HapticsNode, "haptics")
