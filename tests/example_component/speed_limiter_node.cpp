// SPDX-License-Identifier: Apache-2.0
// The component: cmd_vel_in → limited → cmd_vel_out.
#include <tandem/runtime/component.hpp>

#include "speed_limiter.hpp"

namespace example {

using tandem::geometry_msgs::msg::Twist;
namespace rt = tandem::rt;

class SpeedLimiterNode {
 public:
  using Params = SpeedLimits;

  explicit SpeedLimiterNode(rt::Node& node)
      : params_{node.declare_parameters<Params>()},
        out_{node.create_publisher(kOut)},
        in_{node.create_subscription(kIn, [this](const Twist& message) { publish(message); })} {}

  static rt::Interface interface() { return {.subscribes = {kIn}, .publishes = {kOut}}; }

 private:
  static constexpr rt::Topic<Twist> kIn{"cmd_vel_in"}, kOut{"cmd_vel_out"};

  void publish(const Twist& message) {
    const auto safe = limited({message.linear().x(), message.angular().z()}, *params_);
    Twist out;
    out.linear().x(safe.v);
    out.angular().z(safe.w);
    out_.publish(out);
  }

  rt::Parameters<Params> params_;
  rt::Publisher<Twist> out_;
  rt::Subscription in_;
};

}  // namespace example

TANDEM_COMPONENT(example::SpeedLimiterNode, "speed_limiter")
