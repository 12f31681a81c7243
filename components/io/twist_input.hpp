// SPDX-License-Identifier: Apache-2.0
// Subscribes to velocity commands as Twist and TwistStamped under one topic name, and drops stale
// ones.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "tandem/io/conversions.hpp"
#include "tandem/io/stamp_check.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Subscribes to a velocity topic: to Twist always, to TwistStamped while a node publishes that
/// type, because tools of ROS 2 refuse a topic with two types. Commands that are not finite are
/// logged and dropped, and so are those in the map or odom frame: v and w refer to the robot's
/// frame, whatever its name.
class TwistInput {
 public:
  /// Takes a command, on the node's thread.
  using Command = std::function<void(const Twist2&)>;

  /// Subscribes to the topic with another QoS. `node` must outlive this.
  TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic, const rt::QoS& qos,
             const StampParams& params, Command command);
  TwistInput(rt::Node& node, const rt::Topic<geometry_msgs::msg::Twist>& topic,
             const StampParams& params, Command command)
      : TwistInput{node, topic, topic.qos, params, std::move(command)} {}
  /// The topics that it opens with these arguments.
  [[nodiscard]] static rt::Interface interface(const rt::Topic<geometry_msgs::msg::Twist>& topic,
                                               const rt::QoS& qos);
  [[nodiscard]] static rt::Interface interface(const rt::Topic<geometry_msgs::msg::Twist>& topic) {
    return interface(topic, topic.qos);
  }
  /// Compares timestamps with `now` [s] instead of the node's clock, for a node that generates
  /// time.
  void check_stamps_by(std::function<double()> now) { check_.check_by(std::move(now)); }
  /// Sets the frame names if they differ from the defaults.
  void set_frames(Frames frames) { frames_ = std::move(frames); }
  /// Also delivers commands that are not finite, for a node that stops on them.
  void pass_not_finite() { passes_not_finite_ = true; }
  /// As Subscription::may_wait(), for a node that uses commands in timers only.
  void may_wait(double seconds);
  /// The publisher of the last command; valid within its callback.
  [[nodiscard]] rt::PublisherId sender() const { return sender_; }
  /// Whether the last command was a TwistStamped; valid within its callback.
  [[nodiscard]] bool is_stamped() const { return is_stamped_; }
  TwistInput(const TwistInput&) = delete;
  TwistInput& operator=(const TwistInput&) = delete;

 private:
  void subscribe_stamped(const rt::QoS& qos);
  [[nodiscard]] bool is_of_robot(const std::string& frame) const;
  void receive(const geometry_msgs::msg::Twist& msg, const rt::Subscription& from);

  rt::Node& node_;
  rt::Topic<geometry_msgs::msg::TwistStamped> stamped_topic_;
  StampCheck check_;
  Command command_;
  Frames frames_;
  bool passes_not_finite_ = false;
  double patience_ = 0.0;  // [s]
  rt::PublisherId sender_{};
  bool is_stamped_ = false;
  rt::Subscription plain_;
  std::optional<rt::Subscription> stamped_;
  std::shared_ptr<void> stamped_publishers_;
};

}  // namespace tandem
