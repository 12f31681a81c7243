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
struct RangeReturns {
  std::vector<Eigen::Vector3d> p_SQ;     ///< something stands here [m]
  std::vector<Eigen::Vector3d> p_SFree;  ///< nothing stands on the way to here [m]
  std::string error;
};

/// A plane of ranges, as in sensor_msgs/LaserScan: beam i at angle_min + i · angle_increment, taken
/// i · time_increment after the first.
struct RangeScan {
  double angle_min = 0.0, angle_increment = 0.0;  ///< [rad]
  double range_min = 0.0, range_max = 0.0;        ///< [m]; range_max may be +inf
  double time_increment = 0.0;                    ///< [s]
  double scan_time = 0.0;                         ///< [s] from one scan to the next; 0: not given
  std::span<const float> ranges;                  ///< [m]
};

/// Which values a driver sends where nothing is in range.
struct NoReturn {
  bool inf = true;         ///< +inf, as REP 117 has it
  bool range_max = false;  ///< range_max, or a finite value beyond it
  bool zero = false;
  bool nan = false;
};

/// What `no_return` may name.
inline const std::vector<std::string> kNoReturnNames{"inf", "range_max", "zero", "nan"};

/// The values that the names stand for; other names than kNoReturnNames are ignored.
[[nodiscard]] NoReturn no_return_of(std::span<const std::string> names);

/// What one beam says.
enum class Beam {
  kEcho,     ///< something stands at the range
  kFree,     ///< nothing is in range
  kInvalid,  ///< nothing can be concluded
};

/// Values of no_return are kFree, and +inf only if it is one of them. Otherwise NaN, zero, −inf,
/// what is below range_min and what is beyond range_max are invalid (sensor_msgs/LaserScan discards
/// them); a reading of exactly range_max is an echo.
[[nodiscard]] Beam beam_of(float range, const RangeScan& scan, const NoReturn& no_return);

/// Why the scan's numbers cannot be right, in one line; empty if they can.
[[nodiscard]] std::string error_of(const RangeScan& scan);

/// Why the beams cannot have been taken when time_increment says, in one line that names the field;
/// empty if they can. It may not be negative, nor add up to more than scan_time (1 s if that is not
/// given).
[[nodiscard]] std::string time_error_of(const RangeScan& scan);

/// By beam_of. Where nothing is in range the way is free up to range_max, or up to 1000 m.
[[nodiscard]] RangeReturns range_returns_of(const RangeScan& scan, const NoReturn& no_return = {});

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
[[nodiscard]] RangeReturns range_returns_of(const CloudLayout& layout,
                                            std::span<const std::uint8_t> data);

}  // namespace tandem
