// SPDX-License-Identifier: Apache-2.0
// In: Twist and TwistStamped under one topic name. Out: the commands of both, none that is old.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "runtime/node.hpp"
#include "stamp_check.hpp"

namespace tandem {

/// Subscribes a velocity topic for a node. Plain Twist at once, TwistStamped from when somebody
/// publishes that type.
class TwistInput {
 public:
  using Command = std::function<void(const geometry_msgs::msg::Twist&)>;

  TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic, const rt::QoS& qos,
             const StampParams& params, Command command);
  TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic,
             const StampParams& params, Command command)
      : TwistInput{node, topic, topic.qos, params, std::move(command)} {}
  /// Stamps are of this time [s], for a node that makes it; else of the node's own.
  void judge_stamps_by(std::function<double()> now) { check_.judge_by(std::move(now)); }
  TwistInput(const TwistInput&) = delete;
  TwistInput& operator=(const TwistInput&) = delete;

 private:
  void subscribe_stamped(const rt::QoS& qos);

  rt::Node& node_;
  rt::Topic<geometry_msgs::msg::TwistStamped> stamped_topic_;
  StampCheck check_;
  Command command_;
  rt::Subscription plain_, stamped_;
  std::shared_ptr<void> stamped_wanted_;
};

}  // namespace tandem
