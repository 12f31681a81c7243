// SPDX-License-Identifier: Apache-2.0
#include "twist_input.hpp"

#include "convert.hpp"

namespace tandem {

TwistInput::TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic,
                       const rt::QoS& qos, const StampParams& params, Command command)
    : node_{node},
      stamped_topic_{topic.name, topic.qos},
      check_{node, topic.name, params},
      command_{std::move(command)},
      plain_{node.create_subscription(topic, qos, [this](const auto& msg) { hear(msg, plain_); })},
      stamped_wanted_{
          node.when_published(stamped_topic_, [this, qos] { subscribe_stamped(qos); })} {}

void TwistInput::subscribe_stamped(const rt::QoS& qos) {
  node_.log().info("{} comes as TwistStamped too", stamped_topic_.name);
  stamped_ = node_.create_subscription(stamped_topic_, qos, [this](const auto& msg) {
    if (check_.in_time(msg.header().stamp())) hear(msg.twist(), stamped_);
  });
}

void TwistInput::hear(const geometry_msgs::msg::Twist& msg, const rt::Subscription& from) {
  sender_ = from.sender();
  if (const auto twist = from_msg(msg)) return command_(*twist);
  if (passes_not_finite_) return command_({msg.linear().x(), msg.angular().z()});
  node_.log().write_every(1.0, rt::LogLevel::kWarn, stamped_topic_.name,
                          std::string{stamped_topic_.name} + " is not finite: dropped");
}

}  // namespace tandem
