// SPDX-License-Identifier: Apache-2.0
// Builds a map with one wall, in any frame.
#pragma once

#include <string>

#include "tandem/io/conversions.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem::test {

inline constexpr double kWall = 0.9;  // [m] ahead of the robot's centre, in odom

// A wall across the robot's path, at the origin of odometry.
inline octomap_msgs::msg::Octomap wall(const std::string& frame) {
  octomap::OcTree tree(0.05);
  for (int i = -40; i <= 40; ++i) tree.updateNode(kWall + 0.01, 0.05 * i + 0.01, 0.3, true);
  octomap_msgs::msg::Octomap msg;
  msg.header(header({}, frame));
  msg.binary(true);
  msg.id("OcTree");
  msg.resolution(0.05);
  msg.data(encode_octomap(tree));
  return msg;
}

}  // namespace tandem::test
