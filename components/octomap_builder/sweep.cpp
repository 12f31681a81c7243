// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/sweep.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

constexpr double kTurn = 0.01;  // [rad]
constexpr double kWay = 0.02;   // [m]
constexpr double kMaxParts = 100.0;

std::size_t parts_between(const Eigen::Isometry3d& first, const Eigen::Isometry3d& last) {
  const double turn = Eigen::AngleAxisd{first.linear().transpose() * last.linear()}.angle();
  const double way = (last.translation() - first.translation()).norm();
  return static_cast<std::size_t>(
      std::clamp(std::ceil(std::max(turn / kTurn, way / kWay)), 1.0, kMaxParts));
}

RangeScan part_of(const RangeScan& scan, std::size_t begin, std::size_t end) {
  RangeScan part = scan;
  part.angle_min += static_cast<double>(begin) * scan.angle_increment;
  part.ranges = scan.ranges.subspan(begin, end - begin);
  return part;
}

}  // namespace

std::optional<std::vector<Look>> looks_of(const RangeScan& scan, const PoseAfter& pose_after,
                                          const NoReturn& no_return) {
  const std::size_t beams = scan.ranges.size();
  const auto after = [&](double beam) { return pose_after(beam * scan.time_increment); };
  const auto first = after(0.0),
             last = after(static_cast<double>(std::max<std::size_t>(beams, 1) - 1));
  if (!first || !last) return std::nullopt;
  const std::size_t parts = parts_between(*first, *last);
  std::vector<Look> looks;
  for (std::size_t i = 0; i < parts; ++i) {
    const std::size_t begin = beams * i / parts, end = beams * (i + 1) / parts;
    if (begin == end && parts > 1) continue;
    const auto X_MS = after(0.5 * static_cast<double>(begin + std::max(end, begin + 1) - 1));
    if (!X_MS) return std::nullopt;
    looks.push_back({range_returns_of(part_of(scan, begin, end), no_return), *X_MS});
  }
  return looks;
}

}  // namespace tandem
