// SPDX-License-Identifier: Apache-2.0
#include "twist_input.hpp"

#include <cmath>

namespace tandem {
TwistInput::TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic,
                       const rt::QoS& qos, const TwistInputParams& params, Command command)
    : node_{node},
      stamped_topic_{topic.name, topic.qos},
      max_stamp_age_{params.max_stamp_age},
      command_{std::move(command)},
      now_{[&node] { return rt::to_seconds(node.stamp()); }},
      plain_{node.create_subscription(topic, qos, command_)},
      stamped_wanted_{
          node.when_published(stamped_topic_, [this, qos] { subscribe_stamped(qos); })} {}

void TwistInput::subscribe_stamped(const rt::QoS& qos) {
  node_.log().info("{} comes as TwistStamped too", stamped_topic_.name);
  stamped_ = node_.create_subscription(stamped_topic_, qos, [this](const auto& msg) {
    if (in_time(msg.header().stamp())) command_(msg.twist());
  });
}

// Either way: a clock that runs ahead would hide how old a command is.
bool TwistInput::in_time(const builtin_interfaces::msg::Time& stamp) const {
  if (max_stamp_age_ == 0.0 || (stamp.sec() == 0 && stamp.nanosec() == 0)) return true;
  const double age = now_() - rt::to_seconds(stamp);
  if (std::abs(age) <= max_stamp_age_) return true;
  node_.log().warn_every(1.0,
                         "{}: a command stamped {:.3f} s {} was dropped (max_stamp_age {} s): it "
                         "came late, or the sender's clock is wrong",
                         stamped_topic_.name, std::abs(age), age > 0.0 ? "ago" : "ahead",
                         max_stamp_age_);
  return false;
}

}  // namespace tandem
