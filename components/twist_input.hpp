// SPDX-License-Identifier: Apache-2.0
// In: Twist and TwistStamped under one topic name. Out: the commands of both, none that is old.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "runtime/node.hpp"

namespace tandem {

struct TwistInputParams {
  double max_stamp_age = 0.5;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("max_stamp_age", max_stamp_age, Range{0.0, 60.0},
          "[s] that the stamp of a TwistStamped may differ from now, else it is dropped; 0: any");
  }
};

/// Subscribes a velocity topic for a node. Plain Twist at once, TwistStamped from when somebody
/// publishes that type; a stamp of zero counts as none.
class TwistInput {
 public:
  using Command = std::function<void(const geometry_msgs::msg::Twist&)>;

  TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic, const rt::QoS& qos,
             const TwistInputParams& params, Command command);
  TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic,
             const TwistInputParams& params, Command command)
      : TwistInput{node, topic, topic.qos, params, std::move(command)} {}
  /// Stamps are of this time [s], for a node that makes it; else of the node's own.
  void judge_stamps_by(std::function<double()> now) { now_ = std::move(now); }
  TwistInput(const TwistInput&) = delete;
  TwistInput& operator=(const TwistInput&) = delete;

 private:
  void subscribe_stamped(const rt::QoS& qos);
  [[nodiscard]] bool in_time(const builtin_interfaces::msg::Time& stamp) const;

  rt::Node& node_;
  rt::Topic<geometry_msgs::msg::TwistStamped> stamped_topic_;
  double max_stamp_age_;  // [s]
  Command command_;
  std::function<double()> now_;
  rt::Subscription plain_, stamped_;
  std::shared_ptr<void> stamped_wanted_;
};

}  // namespace tandem
