// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/robot_description.hpp"

#include <utility>

namespace tandem {
namespace {

constexpr double kSettling = 1.0;  // [s]

}  // namespace

rt::Interface RobotDescription::interface() {
  return {.publishes = {{topics::robot_description, "publish_description: true"}}};
}

RobotDescription::RobotDescription(rt::Node& node, std::string urdf) : node_{node} {
  urdf_.data(std::move(urdf));
  publishers_ = node.watch_publishers(topics::robot_description, [this](const auto& offered) {
    others_ = offered.size() > (publisher_ ? 1U : 0U);
    update();
  });
  settling_ = node.create_wall_timer(kSettling, [this] {
    settled_ = true;
    settling_ = {};
    update();
  });
}

void RobotDescription::update() {
  const bool wanted = settled_ && !others_;
  if (wanted == publisher_.has_value()) return;
  if (!wanted) {
    publisher_.reset();
    node_.log().info("robot_description is left to another node");
    return;
  }
  publisher_ = node_.create_publisher(topics::robot_description);
  publisher_->publish(urdf_);
}

}  // namespace tandem
