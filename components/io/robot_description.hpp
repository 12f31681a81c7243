// SPDX-License-Identifier: Apache-2.0
// Publishes the robot's shape for RViz, unless another node does.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tandem/io/topics.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {

/// Publishes a URDF document on robot_description, latched, while no other node publishes that
/// topic (robot_state_publisher, for example): from a second after its construction on, in which
/// others are discovered.
class RobotDescription {
 public:
  /// `node` must outlive this.
  RobotDescription(rt::Node& node, std::string urdf);
  /// The topic that it opens, in a component with the parameter `publish_description`.
  [[nodiscard]] static rt::Interface interface();
  RobotDescription(const RobotDescription&) = delete;
  RobotDescription& operator=(const RobotDescription&) = delete;

 private:
  void update();

  rt::Node& node_;
  std_msgs::msg::String urdf_;
  bool settled_ = false;  // whether publishers that were there before have been discovered
  bool others_ = false;
  std::optional<rt::Publisher<std_msgs::msg::String>> publisher_;
  std::shared_ptr<void> publishers_;
  rt::Timer settling_;
};

}  // namespace tandem
