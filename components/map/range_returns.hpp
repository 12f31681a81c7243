// SPDX-License-Identifier: Apache-2.0
// Converts the measurements of a range sensor into points that are occupied and rays that are free.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tandem {

/// One measurement of a sensor, in its own frame S. With an `error` (one line) there are no points.
struct RangeReturns {
  std::vector<Eigen::Vector3d> p_SQ;     ///< occupied points [m]
  std::vector<Eigen::Vector3d> p_SFree;  ///< ends of rays on which nothing was hit [m]
  std::string error;                     ///< what is wrong with the message; empty if nothing is
};

/// A planar scan, as in sensor_msgs/LaserScan: beam i at angle_min + i · angle_increment, taken i ·
/// time_increment after the first.
struct RangeScan {
  double angle_min = 0.0, angle_increment = 0.0;  ///< [rad]
  double range_min = 0.0, range_max = 0.0;        ///< [m]; range_max may be +inf
  double time_increment = 0.0;                    ///< [s]
  double scan_time = 0.0;                         ///< [s] between two scans; 0: unknown
  std::span<const float> ranges;                  ///< [m]
};

/// The values that a driver sends where nothing is in range.
struct NoReturn {
  bool inf = true;         ///< +inf, as in REP 117
  bool range_max = false;  ///< range_max, or a finite value beyond it
  bool zero = false;       ///< a range of 0 means that nothing was in range
  bool nan = false;        ///< NaN means that nothing was in range
};

/// Names allowed in `no_return`.
inline const std::vector<std::string> kNoReturnNames{"inf", "range_max", "zero", "nan"};

/// The values for these names; names not in kNoReturnNames are ignored.
[[nodiscard]] NoReturn no_return_of(std::span<const std::string> names);

/// Result of one beam.
enum class Beam {
  kEcho,     ///< an obstacle at the range
  kFree,     ///< nothing in range
  kInvalid,  ///< nothing can be concluded
};

/// Values named by no_return are kFree. Otherwise NaN, zero, ±inf, values below range_min and
/// values beyond range_max are kInvalid (sensor_msgs/LaserScan discards them). A reading of exactly
/// range_max is kEcho unless no_return names range_max.
[[nodiscard]] Beam beam_of(float range, const RangeScan& scan, const NoReturn& no_return);

/// Why the scan's numbers are inconsistent, in one line; empty if they are valid.
[[nodiscard]] std::string error_of(const RangeScan& scan);

/// Why time_increment cannot be right, in one line that names the field; empty if it can. It may
/// not be negative, nor add up to more than scan_time (with 10 % tolerance) or 1 s.
[[nodiscard]] std::string time_error_of(const RangeScan& scan);

/// Classifies the beams by beam_of. Where nothing is in range, the ray is free up to range_max, or
/// 1000 m if that is less.
[[nodiscard]] RangeReturns range_returns_of(const RangeScan& scan, const NoReturn& no_return = {});

/// A field of a point, as in sensor_msgs/PointField.
struct CloudField {
  std::string name;           ///< x, y and z are read
  std::uint32_t offset = 0;   ///< [bytes] from the start of the point
  std::uint8_t datatype = 0;  ///< 7 is FLOAT32, 8 is FLOAT64
};

/// Memory layout of the points in a sensor_msgs/PointCloud2.
struct CloudLayout {
  std::uint32_t height = 0, width = 0;         ///< rows, and points in a row
  std::vector<CloudField> fields;              ///< of each point
  bool is_bigendian = false;                   ///< byte order of all numbers
  std::uint32_t point_step = 0, row_step = 0;  ///< [bytes]
};

/// Points of a cloud from its fields x, y and z (FLOAT32 or FLOAT64); other fields are not read.
/// Points that are not finite are skipped. Any layout and any bytes are safe.
[[nodiscard]] RangeReturns range_returns_of(const CloudLayout& layout,
                                            std::span<const std::uint8_t> data);

}  // namespace tandem
