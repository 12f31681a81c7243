// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tandem/map/static_map.hpp"

namespace tandem {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// One axis of the cell-by-cell traversal (Amanatides and Woo 1987); lengths in cells.
struct Axis {
  double start, direction;
  int cell = 0;

  // Interval [t0, t1] of the ray within [0, size]; empty if t0 > t1.
  [[nodiscard]] std::pair<double, double> within(double size) const {
    if (direction == 0.0)
      return start >= 0.0 && start <= size ? std::pair{0.0, kNever} : std::pair{1.0, 0.0};
    const double a = -start / direction, b = (size - start) / direction;
    return {std::min(a, b), std::max(a, b)};
  }
  void enter(double t, int size) {
    cell = static_cast<int>(std::clamp(std::floor(start + t * direction), 0.0, size - 1.0));
  }
  [[nodiscard]] double leaves_at() const {
    if (direction == 0.0) return kNever;
    return (cell + (direction > 0.0 ? 1 : 0) - start) / direction;
  }
  void step() { cell += direction > 0.0 ? 1 : -1; }
};

}  // namespace

double StaticMap::cast_ray(const Eigen::Vector2d& p_MQ, double heading, double max_range) const {
  if (!p_MQ.allFinite() || !std::isfinite(heading)) return 0.0;
  const Eigen::Vector2d start = (p_MQ - grid_.origin) * cells_per_metre_;
  Axis x{start.x(), std::cos(heading)}, y{start.y(), std::sin(heading)};
  const double range = max_range * cells_per_metre_;

  const auto [x_in, x_out] = x.within(grid_.width);
  const auto [y_in, y_out] = y.within(grid_.height);
  double t = std::max({0.0, x_in, y_in});
  if (unknown_is_obstacle_ && (t > 0.0 || x_out < 0.0 || y_out < 0.0)) return 0.0;
  if (grid_.cells.empty() || t > std::min({x_out, y_out, range})) return max_range;

  x.enter(t, grid_.width);
  y.enter(t, grid_.height);
  while (t <= range) {
    if (!grid_.contains(x.cell, y.cell)) {
      if (unknown_is_obstacle_) break;
      return max_range;
    }
    const double free = static_cast<double>(field(x.cell, y.cell)) * cells_per_metre_;
    if (free == 0.0) break;
    if (free > 4.0 && t + free < range) {  // from anywhere in this cell, free − √½ is clear
      t += free - 1.0;
      x.enter(t, grid_.width);
      y.enter(t, grid_.height);
      continue;
    }
    Axis& next = x.leaves_at() < y.leaves_at() ? x : y;
    t = std::max(t, next.leaves_at());
    next.step();
  }
  return std::min(max_range, t * grid_.resolution);
}

}  // namespace tandem
