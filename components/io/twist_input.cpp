// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/twist_input.hpp"

#include "tandem/model/frame_tree.hpp"

namespace tandem {
namespace {

rt::Topic<geometry_msgs::msg::TwistStamped> stamped(
    const rt::Topic<geometry_msgs::msg::Twist>& topic) {
  return {topic.name, topic.qos};
}

}  // namespace

TwistInput::TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic,
                       const rt::QoS& qos, const StampParams& params, Command command)
    : node_{node},
      stamped_topic_{stamped(topic)},
      check_{node, topic.name, params},
      command_{std::move(command)},
      plain_{
          node.create_subscription(topic, qos, [this](const auto& msg) { receive(msg, plain_); })},
      stamped_publishers_{node.watch_publishers(stamped_topic_, [this, qos](const auto& offered) {
        if (offered.empty())
          stamped_.reset();
        else if (!stamped_)
          subscribe_stamped(qos);
      })} {}

rt::Interface TwistInput::interface(const rt::Topic<geometry_msgs::msg::Twist>& topic,
                                    const rt::QoS& qos) {
  return {.subscribes = {{topic, qos}, {stamped(topic), qos, "a node publishes TwistStamped"}}};
}

void TwistInput::may_wait(double seconds) {
  patience_ = seconds;
  plain_.may_wait(seconds);
  if (stamped_) stamped_->may_wait(seconds);
}

void TwistInput::subscribe_stamped(const rt::QoS& qos) {
  node_.log().info("{} is received as TwistStamped too", stamped_topic_.name);
  stamped_ = node_.create_subscription(stamped_topic_, qos, [this](const auto& msg) {
    if (is_of_robot(msg.header().frame_id()) && check_.in_time(msg.header().stamp()))
      receive(msg.twist(), *stamped_);
  });
  stamped_->may_wait(patience_);
}

bool TwistInput::is_of_robot(const std::string& frame) const {
  const auto name = bare_frame(frame);
  if (name != bare_frame(frames_.map) && name != bare_frame(frames_.odom)) return true;
  node_.log().write_every(
      1.0, rt::LogLevel::kWarn, stamped_topic_.name,
      fmt::format("{} is given in frame `{}`, which does not move with the robot: dropped; "
                  "commands must be in the robot's own frame (`{}`, or none)",
                  stamped_topic_.name, frame, frames_.base));
  return false;
}

void TwistInput::receive(const geometry_msgs::msg::Twist& msg, const rt::Subscription& from) {
  sender_ = from.sender();
  is_stamped_ = &from != &plain_;
  if (const auto twist = from_msg(msg)) return command_(*twist);
  if (passes_not_finite_) return command_({msg.linear().x(), msg.angular().z()});
  node_.log().write_every(1.0, rt::LogLevel::kWarn, stamped_topic_.name,
                          std::string{stamped_topic_.name} + " is not finite: dropped");
}

}  // namespace tandem
