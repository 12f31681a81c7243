// SPDX-License-Identifier: Apache-2.0
#include "robot_state_input.hpp"

#include <algorithm>

#include "topics.hpp"

namespace tandem {

RobotStateInput::RobotStateInput(rt::Node& node, const RobotStateParams& params,
                                 std::function<void(double)> on_odom)
    : node_{node},
      params_{params},
      localization_{params.localization},
      on_odom_{std::move(on_odom)} {
  odom_ = node.create_subscription(topics::odom, [this](const nav_msgs::msg::Odometry& msg) {
    const auto odometry = from_msg(msg);
    if (!odometry) {
      node_.log().warn_every(1.0, "odom is not finite: dropped");
      return;
    }
    localization_.on_odom(odometry->X, odometry->twist, node_.now(),
                          lateness(msg.header().stamp()));
    tell();
    if (on_odom_) on_odom_(rt::to_seconds(msg.header().stamp()));
  });
  tf_ = node.create_subscription(topics::tf, [this](const tf2_msgs::msg::TFMessage& msg) {
    const auto& frames = params_.frames;
    const auto X_MW = find_transform(msg, frames.map, frames.odom);
    if (!X_MW) return;
    localization_.on_transform(*X_MW, node_.now());
    tell();
  });
  tf_static_ = node.create_subscription(topics::tf_static, [this](const auto& msg) {
    const auto X_MW = find_transform(msg, params_.frames.map, params_.frames.odom);
    if (!X_MW) return;
    localization_.on_static_transform(*X_MW);
    tell();
  });
}

void RobotStateInput::tell() {
  if (!on_state_) return;
  if (const auto heard = state()) on_state_(*heard);
}

double RobotStateInput::lateness(const Stamp& stamp) const {
  if (!usual_age_ || (stamp.sec() == 0 && stamp.nanosec() == 0)) return 0.0;
  const double late = rt::to_seconds(node_.stamp()) - rt::to_seconds(stamp) - *usual_age_;
  if (late > params_.localization.odom_timeout)
    node_.log().warn_every(1.0,
                           "odom comes {:.3f} s late by its stamp: the network is slow, or the "
                           "sender's clock is wrong (odom_stamped: false if it cannot be set)",
                           late);
  return std::max(0.0, late);
}

std::optional<RobotState> RobotStateInput::state() { return localization_.state(node_.now()); }

}  // namespace tandem
