// SPDX-License-Identifier: Apache-2.0
// Converts mounting parameters to poses in space.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tandem {

/// X_BS of a sensor from the parameter `name`: x, y, z, roll, pitch, yaw [m, rad], in the order of
/// static_transform_publisher; nullopt if `numbers` is empty. Throws std::invalid_argument if there
/// are numbers, but not six.
[[nodiscard]] inline std::optional<Eigen::Isometry3d> mounting(const std::string& name,
                                                               const std::vector<double>& numbers) {
  if (numbers.empty()) return std::nullopt;
  if (numbers.size() != 6)
    throw std::invalid_argument(name + ": expected six numbers: x, y, z, roll, pitch, yaw");
  return Eigen::Translation3d(numbers[0], numbers[1], numbers[2]) *
         Eigen::AngleAxisd(numbers[5], Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(numbers[4], Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(numbers[3], Eigen::Vector3d::UnitX());
}

}  // namespace tandem
