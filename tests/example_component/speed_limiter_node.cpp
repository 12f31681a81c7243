// SPDX-License-Identifier: Apache-2.0
// The component: cmd_vel_in → limited → cmd_vel_out, and a report with a message of its own.
#include <example_msgs/messages.hpp>
#include <tandem/runtime/component.hpp>

#include "speed_limiter.hpp"

namespace example {

using tandem::example_msgs::msg::Limited;
using tandem::geometry_msgs::msg::Twist;
namespace rt = tandem::rt;

class SpeedLimiterNode {
 public:
  using Params = SpeedLimits;

  explicit SpeedLimiterNode(rt::Node& node)
      : params_{node.declare_parameters<Params>()},
        out_{node.create_publisher(kOut)},
        limited_{node.create_publisher(kLimited)},
        in_{node.create_subscription(kIn, [this](const Twist& message) { publish(message); })} {}

  static rt::Interface interface() { return {.subscribes = {kIn}, .publishes = {kOut, kLimited}}; }

 private:
  static constexpr rt::Topic<Twist> kIn{"cmd_vel_in"}, kOut{"cmd_vel_out"};
  static constexpr rt::Topic<Limited> kLimited{"limited"};

  void publish(const Twist& message) {
    const tandem::Twist2 wanted{message.linear().x(), message.angular().z()};
    const double factor = factor_for(wanted, *params_);
    Twist out;
    out.linear().x(factor * wanted.v);
    out.angular().z(factor * wanted.w);
    out_.publish(out);
    Limited report;
    report.wanted(message);
    report.factor(factor);
    limited_.publish(report);
  }

  rt::Parameters<Params> params_;
  rt::Publisher<Twist> out_;
  rt::Publisher<Limited> limited_;
  rt::Subscription in_;
};

}  // namespace example

TANDEM_COMPONENT(example::SpeedLimiterNode, "speed_limiter")
