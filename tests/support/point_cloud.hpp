// SPDX-License-Identifier: Apache-2.0
// Builds a PointCloud2 from points, as a depth camera publishes it.
#pragma once

#include <Eigen/Core>
#include <cstring>
#include <vector>

#include <msgs.hpp>

namespace tandem::test {

/// Fields x, y and z are float32, in one row.
inline sensor_msgs::msg::PointCloud2 cloud_of(const std::vector<Eigen::Vector3f>& p_SQ,
                                              const std_msgs::msg::Header& header) {
  constexpr std::uint32_t kStep = 12;
  sensor_msgs::msg::PointCloud2 msg;
  msg.header(header);
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z"}) {
    sensor_msgs::msg::PointField field;
    field.name(name);
    field.offset(offset);
    field.datatype(7);
    field.count(1);
    msg.fields().push_back(field);
    offset += 4;
  }
  msg.height(1);
  msg.width(static_cast<std::uint32_t>(p_SQ.size()));
  msg.point_step(kStep);
  msg.row_step(kStep * msg.width());
  msg.data().resize(msg.row_step());
  for (std::size_t i = 0; i < p_SQ.size(); ++i)
    std::memcpy(&msg.data()[kStep * i], p_SQ[i].data(), kStep);
  return msg;
}

}  // namespace tandem::test
