// SPDX-License-Identifier: Apache-2.0
// In: what a range sensor measured. Out: where something stood, and where surely nothing did.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tandem {

/// One look of a sensor, in its own frame S. With an `error` (one line) there are no points.
struct Echoes {
  std::vector<Eigen::Vector3d> p_SQ;     ///< something stands here [m]
  std::vector<Eigen::Vector3d> p_SFree;  ///< nothing stands on the way to here [m]
  std::string error;
};

/// A plane of ranges, as in sensor_msgs/LaserScan: beam i at angle_min + i · angle_increment, taken
/// i · time_increment after the first.
struct RangeScan {
  double angle_min = 0.0, angle_increment = 0.0;  ///< [rad]
  double range_min = 0.0, range_max = 0.0;        ///< [m]
  double time_increment = 0.0;                    ///< [s]
  std::span<const float> ranges;                  ///< [m]
};

/// Why the scan's numbers cannot be right, in one line; empty if they can.
[[nodiscard]] std::string error_of(const RangeScan& scan);

/// +inf, and what is range_max or more, is a beam that met nothing up to range_max (REP 117). NaN,
/// −inf and what is below range_min say nothing.
[[nodiscard]] Echoes echoes_of(const RangeScan& scan);

/// A field of a point, as in sensor_msgs/PointField.
struct CloudField {
  std::string name;
  std::uint32_t offset = 0;   ///< [bytes] from the point's first
  std::uint8_t datatype = 0;  ///< 7 is FLOAT32, 8 is FLOAT64
};

/// How the points lie in the bytes of a sensor_msgs/PointCloud2.
struct CloudLayout {
  std::uint32_t height = 0, width = 0;
  std::vector<CloudField> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0, row_step = 0;  ///< [bytes]
};

/// Points of a cloud by its fields x, y and z (FLOAT32 or FLOAT64); other fields are not read. A
/// point that is not finite says nothing. Any layout and any bytes are safe.
[[nodiscard]] Echoes echoes_of(const CloudLayout& layout, std::span<const std::uint8_t> data);

}  // namespace tandem
