// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/range_returns.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <sstream>

namespace tandem {
namespace {

constexpr std::uint8_t kFloat32 = 7, kFloat64 = 8;  // of sensor_msgs/PointField
constexpr std::size_t kMaxPoints = 10'000'000;
constexpr double kFarthest = 1000.0;       // [m] longest free ray
constexpr double kLongestScan = 1.0;       // [s]
constexpr double kScanTimeAccuracy = 1.1;  // factor, because drivers round scan_time

RangeReturns refused(std::string error) { return {{}, {}, std::move(error)}; }

std::size_t size_of(std::uint8_t datatype) { return datatype == kFloat32 ? 4 : 8; }

template <class Float>
double read_float(const std::uint8_t* bytes, bool swap) {
  std::array<std::uint8_t, sizeof(Float)> raw;
  std::copy_n(bytes, raw.size(), raw.begin());
  if (swap) std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<Float>(raw));
}

double read(const CloudField& field, const std::uint8_t* point, bool swap) {
  const std::uint8_t* bytes = point + field.offset;
  return field.datatype == kFloat32 ? read_float<float>(bytes, swap)
                                    : read_float<double>(bytes, swap);
}

// Why the layout does not match the bytes; empty if it does.
std::string layout_error(const CloudLayout& layout, std::size_t bytes) {
  const std::uint64_t row = std::uint64_t{layout.width} * layout.point_step;
  if (layout.point_step == 0) return "point_step is 0";
  if (layout.height > 1 && layout.row_step < row)
    return "row_step = " + std::to_string(layout.row_step) +
           " is smaller than width × point_step = " + std::to_string(row);
  // Both factors are below 2³², so neither product overflows.
  if (std::uint64_t{layout.height} * layout.width > kMaxPoints)
    return "more than " + std::to_string(kMaxPoints) + " points";
  const std::uint64_t needed = std::uint64_t{layout.height - 1} * layout.row_step + row;
  if (needed > bytes)
    return "data holds " + std::to_string(bytes) +
           " bytes, but height, row_step and width require " + std::to_string(needed);
  return {};
}

// Why the field cannot be read; empty if it can.
std::string field_error(const CloudLayout& layout, const CloudField& field) {
  if (field.datatype != kFloat32 && field.datatype != kFloat64)
    return "field `" + field.name + "` has datatype " + std::to_string(field.datatype) +
           ", not FLOAT32 (7) or FLOAT64 (8)";
  if (std::uint64_t{field.offset} + size_of(field.datatype) > layout.point_step)
    return "field `" + field.name + "` reaches beyond point_step";
  return {};
}

}  // namespace

std::string error_of(const RangeScan& scan) {
  if (!std::isfinite(scan.angle_min) || !std::isfinite(scan.angle_increment))
    return "angle_min and angle_increment must be finite";
  if (!(scan.range_min >= 0.0) || !(scan.range_max > scan.range_min))
    return "range_min and range_max must be 0 ≤ range_min < range_max";
  if (!std::isfinite(scan.time_increment)) return "time_increment must be finite";
  return {};
}

std::string time_error_of(const RangeScan& scan) {
  if (scan.time_increment < 0.0) return "time_increment is negative";
  const double longest = scan.scan_time > 0.0
                             ? std::min(kLongestScan, kScanTimeAccuracy * scan.scan_time)
                             : kLongestScan;
  const double taken = scan.time_increment * static_cast<double>(scan.ranges.size());
  if (taken <= longest) return {};
  std::ostringstream text;
  text << "time_increment = " << scan.time_increment << " s makes the scan " << taken
       << " s long; the maximum is " << longest << " s";
  return text.str();
}

NoReturn no_return_of(std::span<const std::string> names) {
  const auto has = [&](const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return {.inf = has("inf"), .range_max = has("range_max"), .zero = has("zero"), .nan = has("nan")};
}

Beam beam_of(float range, const RangeScan& scan, const NoReturn& no_return) {
  const auto free_if = [](bool is_named) { return is_named ? Beam::kFree : Beam::kInvalid; };
  if (std::isnan(range)) return free_if(no_return.nan);
  if (range == 0.0F) return free_if(no_return.zero);
  if (range == std::numeric_limits<float>::infinity()) return free_if(no_return.inf);
  if (range < scan.range_min || range < 0.0F) return Beam::kInvalid;
  if (range > scan.range_max) return free_if(no_return.range_max);
  return range == scan.range_max && no_return.range_max ? Beam::kFree : Beam::kEcho;
}

RangeReturns range_returns_of(const RangeScan& scan, const NoReturn& no_return) {
  if (auto error = error_of(scan); !error.empty()) return refused(std::move(error));
  RangeReturns echoes;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const Beam beam = beam_of(scan.ranges[i], scan, no_return);
    if (beam == Beam::kInvalid) continue;
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const Eigen::Vector3d direction{std::cos(angle), std::sin(angle), 0.0};
    if (beam == Beam::kEcho)
      echoes.p_SQ.push_back(double{scan.ranges[i]} * direction);
    else
      echoes.p_SFree.push_back(std::min(scan.range_max, kFarthest) * direction);
  }
  return echoes;
}

RangeReturns range_returns_of(const CloudLayout& layout, std::span<const std::uint8_t> data) {
  RangeReturns echoes;
  std::string error;
  std::array<const CloudField*, 3> axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    const auto field = std::find_if(layout.fields.begin(), layout.fields.end(),
                                    [&](const CloudField& f) { return f.name == name; });
    if (field == layout.fields.end()) return refused("no field `" + name + "`");
    if (error = field_error(layout, *field); !error.empty()) return refused(error);
    axes[axis] = &*field;
  }
  if (layout.width == 0 || layout.height == 0) return echoes;
  if (error = layout_error(layout, data.size()); !error.empty()) return refused(error);

  const bool swap = layout.is_bigendian != (std::endian::native == std::endian::big);
  echoes.p_SQ.reserve(std::size_t{layout.height} * layout.width);
  for (std::size_t row = 0; row < layout.height; ++row)
    for (std::size_t column = 0; column < layout.width; ++column) {
      const std::uint8_t* point = &data[row * layout.row_step + column * layout.point_step];
      const Eigen::Vector3d p_SQ{read(*axes[0], point, swap), read(*axes[1], point, swap),
                                 read(*axes[2], point, swap)};
      if (p_SQ.allFinite()) echoes.p_SQ.push_back(p_SQ);
    }
  return echoes;
}

}  // namespace tandem
