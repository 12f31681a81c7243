// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/scan_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tandem {
namespace {

constexpr int kManyScans = 20;

// Kinds of beam values: those that some driver sends for "nothing in range", in the order of
// kNoReturnNames, then the others.
enum Kind : std::size_t { kInf, kRangeMax, kZero, kNan, kTooNear, kInRange, kKinds };
constexpr std::array<const char*, kKinds> kNames{"inf", "range_max or more", "zero",
                                                 "nan", "below range_min",   "in range"};
using Counts = std::array<std::size_t, kKinds>;

Kind kind_of(float range, const RangeScan& scan) {
  if (std::isnan(range)) return kNan;
  if (range == 0.0F) return kZero;
  if (range == std::numeric_limits<float>::infinity()) return kInf;
  if (range < scan.range_min || range < 0.0F) return kTooNear;
  return range >= scan.range_max ? kRangeMax : kInRange;
}

Counts count(const RangeScan& scan) {
  Counts counts{};
  for (const float range : scan.ranges) ++counts[kind_of(range, scan)];
  return counts;
}

std::string composition_of(const RangeScan& scan, std::size_t own_body) {
  if (scan.ranges.empty()) return "no beams";
  const Counts counts = count(scan);
  std::string text;
  for (std::size_t kind = 0; kind < kKinds; ++kind)
    if (counts[kind] > 0)
      text += (text.empty() ? "" : ", ") + std::to_string(counts[kind]) + " " + kNames[kind];
  if (own_body > 0) text += ", of these " + std::to_string(own_body) + " inside the outline";
  return std::to_string(scan.ranges.size()) + " beams: " + text;
}

}  // namespace

ScanReader::ScanReader(const ScanReaderParams& params, double min_range)
    : no_return_{no_return_of(params.no_return)}, min_range_{min_range} {
  check(params);
}

ScanReading ScanReader::read(const RangeScan& scan, const Eigen::Isometry3d& X_BS,
                             const OwnBody& body) {
  ScanReading reading{.error = error_of(scan), .seen = {}};
  if (reading.error.empty()) reading.error = range_max_error(scan);
  if (!reading.error.empty()) return reading;
  reading.seen = range_returns_of(scan, no_return_);
  reading.own_body = body.drop(reading.seen, X_BS);
  reading.composition = composition_of(scan, reading.own_body);
  const auto& echoes = reading.seen.p_SQ;
  const auto far_enough = std::count_if(echoes.begin(), echoes.end(),
                                        [&](const auto& p) { return p.norm() >= min_range_; });
  const auto valid =
      static_cast<double>(far_enough) + static_cast<double>(reading.seen.p_SFree.size());
  if (!scan.ranges.empty()) reading.valid_share = valid / static_cast<double>(scan.ranges.size());
  return reading;
}

// After range_max has varied once it stays an error: while the robot stands still, such a driver
// repeats the same value scan after scan.
std::string ScanReader::range_max_error(const RangeScan& scan) {
  if (!no_return_.range_max) return {};
  if (!range_max_) range_max_ = scan.range_max;
  if (scan.range_max != *range_max_) varies_ = true;
  if (!varies_) return {};
  return "its range_max varies, and no_return names range_max: the farthest return would count as "
         "free space; remove range_max from no_return (or call ~/reset if it was changed on "
         "purpose)";
}

std::optional<std::string> ScanReader::missing_name(const RangeScan& scan) {
  const Counts counts = count(scan);
  const std::array<bool, 4> named{no_return_.inf, no_return_.range_max, no_return_.zero,
                                  no_return_.nan};
  std::string most;
  for (std::size_t kind = 0; kind < named.size(); ++kind)
    if (!named[kind] && 2 * counts[kind] > scan.ranges.size()) most = kNoReturnNames[kind];
  scans_of_most_ = most == most_ ? scans_of_most_ + 1 : 1;
  most_ = most;
  const bool is_told = std::find(told_.begin(), told_.end(), most) != told_.end();
  if (most.empty() || is_told || scans_of_most_ < kManyScans) return std::nullopt;
  told_.push_back(most);
  return most;
}

}  // namespace tandem
