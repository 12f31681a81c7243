// SPDX-License-Identifier: Apache-2.0
#include "twist_input.hpp"

namespace tandem {
TwistInput::TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic,
                       const rt::QoS& qos, const StampParams& params, Command command)
    : node_{node},
      stamped_topic_{topic.name, topic.qos},
      check_{node, topic.name, params},
      command_{std::move(command)},
      plain_{node.create_subscription(topic, qos, command_)},
      stamped_wanted_{
          node.when_published(stamped_topic_, [this, qos] { subscribe_stamped(qos); })} {}

void TwistInput::subscribe_stamped(const rt::QoS& qos) {
  node_.log().info("{} comes as TwistStamped too", stamped_topic_.name);
  stamped_ = node_.create_subscription(stamped_topic_, qos, [this](const auto& msg) {
    if (check_.in_time(msg.header().stamp())) command_(msg.twist());
  });
}

}  // namespace tandem
