// SPDX-License-Identifier: Apache-2.0
// Copies a message of ROS 2 into Tandem's of the same name.
#include <geometry_msgs/msg/twist.hpp>
#include <msgs.hpp>

int main() {
  geometry_msgs::msg::Twist ros;
  ros.linear.x = 0.5;
  tandem::geometry_msgs::msg::Twist ours;
  ours.linear().x(ros.linear.x);
  return ours.linear().x() == 0.5 ? 0 : 1;
}
