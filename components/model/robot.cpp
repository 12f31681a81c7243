// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/robot.hpp"

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace tandem {
namespace {

// Number of vertices of each part. The counts are real numbers because a list parameter has one
// element type.
std::vector<std::size_t> counts_of(const std::vector<double>& footprint_parts,
                                   std::size_t vertices) {
  if (footprint_parts.empty()) return {vertices};
  std::vector<std::size_t> counts;
  for (const double count : footprint_parts) {
    if (!(count >= 3.0 && count <= 1e6) || count != std::floor(count))
      throw std::invalid_argument("footprint_parts: number " + std::to_string(counts.size() + 1) +
                                  " must be a whole number of vertices, at least 3");
    counts.push_back(static_cast<std::size_t>(count));
  }
  const std::size_t sum = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  if (sum != vertices)
    throw std::invalid_argument("footprint_parts: the parts have " + std::to_string(sum) +
                                " vertices in all, but footprint gives " +
                                std::to_string(vertices));
  return counts;
}

}  // namespace

Footprint footprint_of(const RobotParams& robot) {
  if (robot.footprint.empty() && robot.footprint_parts.empty())
    return rectangle(robot.length, robot.width, robot.center_x);
  if (robot.footprint.size() % 2 != 0)
    throw std::invalid_argument("footprint: an odd number of coordinates");
  std::vector<ConvexPolygon> parts;
  auto coordinate = robot.footprint.begin();
  for (const std::size_t count : counts_of(robot.footprint_parts, robot.footprint.size() / 2)) {
    ConvexPolygon& part = parts.emplace_back();
    for (; part.size() < count; coordinate += 2) part.emplace_back(*coordinate, *(coordinate + 1));
  }
  return polygons(std::move(parts));
}

}  // namespace tandem
