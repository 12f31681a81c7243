// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/cost_to_go.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace tandem {
namespace {

constexpr double kUnreachable = std::numeric_limits<double>::infinity();
constexpr double kSlopeReach = 0.2;  // [m] to either side, for measuring a slope

// Cells leave the heap in order of cost and are then final.
class FastMarching {
 public:
  FastMarching(const StaticMap& map, double radius, double narrow_cost)
      : map_{map},
        grid_{map.grid()},
        radius_{radius},
        narrow_cost_{narrow_cost},
        cost_(grid_.cells.size(), kUnreachable),
        final_(grid_.cells.size(), false) {}

  std::vector<float> run(const Eigen::Vector2d& p_MZ) {
    begin_at(p_MZ);
    while (!open_.empty()) {
      const std::size_t cell = open_.top().second;
      open_.pop();
      if (final_[cell]) continue;
      final_[cell] = true;
      const int ix = static_cast<int>(cell % static_cast<std::size_t>(grid_.width));
      const int iy = static_cast<int>(cell / static_cast<std::size_t>(grid_.width));
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        update(ix + dx, iy + dy);
    }
    return {cost_.begin(), cost_.end()};
  }

 private:
  // Initialises the cells around the goal with their distance to it.
  void begin_at(const Eigen::Vector2d& p_MZ) {
    const Eigen::Vector2d cell = (p_MZ - grid_.origin) / grid_.resolution;
    const int x = static_cast<int>(std::floor(cell.x())),
              y = static_cast<int>(std::floor(cell.y()));
    for (int iy = y - 1; iy <= y + 1; ++iy)
      for (int ix = x - 1; ix <= x + 1; ++ix)
        if (grid_.contains(ix, iy)) reach(ix, iy, (grid_.center(ix, iy) - p_MZ).norm());
  }

  void reach(int ix, int iy, double cost) {
    const std::size_t cell = grid_.index(ix, iy);
    if (final_[cell] || cost >= cost_[cell]) return;
    cost_[cell] = cost;
    open_.push({cost, cell});
  }

  [[nodiscard]] double known(int ix, int iy) const {
    return grid_.contains(ix, iy) && final_[grid_.index(ix, iy)] ? cost_[grid_.index(ix, iy)]
                                                                 : kUnreachable;
  }

  // Upwind difference: (V − a)² + (V − b)² = (resolution · cost of a metre)².
  void update(int ix, int iy) {
    if (!grid_.contains(ix, iy)) return;
    const double f =
        grid_.resolution * cost_of_a_metre(map_, grid_.center(ix, iy), radius_, narrow_cost_);
    if (std::isinf(f)) return;
    const double a = std::min(known(ix - 1, iy), known(ix + 1, iy));
    const double b = std::min(known(ix, iy - 1), known(ix, iy + 1));
    const bool one_sided = std::abs(a - b) >= f;  // also if one of them is infinite
    reach(ix, iy,
          one_sided ? std::min(a, b) + f
                    : 0.5 * (a + b + std::sqrt(2.0 * f * f - (a - b) * (a - b))));
  }

  const StaticMap& map_;
  const Grid& grid_;
  double radius_, narrow_cost_;
  std::vector<double> cost_;
  std::vector<bool> final_;
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

}  // namespace

CostToGo::CostToGo(const StaticMap& map, const Eigen::Vector2d& p_MZ, double radius,
                   double narrow_cost)
    : origin_{map.grid().origin},
      resolution_{map.grid().resolution},
      width_{map.grid().width},
      height_{map.grid().height},
      cost_{FastMarching{map, radius, narrow_cost}.run(p_MZ)} {}

double CostToGo::cost(int ix, int iy) const {
  if (ix < 0 || iy < 0 || ix >= width_ || iy >= height_) return kUnreachable;
  return cost_[static_cast<std::size_t>(iy) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(ix)];
}

// Next to cells without a path, only the corners with a path are used.
double CostToGo::at(const Eigen::Vector2d& p_MQ) const {
  const Eigen::Vector2d q = (p_MQ - origin_) / resolution_ - Eigen::Vector2d{0.5, 0.5};
  if (!(q.array().abs() < 1e9).all()) return kUnreachable;
  const int x = static_cast<int>(std::floor(q.x())), y = static_cast<int>(std::floor(q.y()));
  const double sx = q.x() - x, sy = q.y() - y;
  double sum = 0.0, weights = 0.0;
  for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
    const double corner = cost(x + dx, y + dy);
    const double weight = (dx ? sx : 1.0 - sx) * (dy ? sy : 1.0 - sy);
    if (std::isinf(corner)) continue;
    sum += weight * corner;
    weights += weight;
  }
  return weights > 1e-9 ? sum / weights : kUnreachable;
}

double CostToGo::downhill(const Eigen::Vector2d& p_MQ) const {
  const double here = at(p_MQ);
  if (std::isinf(here)) return 0.0;
  const auto slope = [&](const Eigen::Vector2d& step) {
    const double ahead = at(p_MQ + step), behind = at(p_MQ - step);
    if (std::isinf(ahead)) return std::isinf(behind) ? 0.0 : 2.0 * (here - behind);
    return std::isinf(behind) ? 2.0 * (ahead - here) : ahead - behind;
  };
  const double dx = slope({kSlopeReach, 0.0}), dy = slope({0.0, kSlopeReach});
  return dx == 0.0 && dy == 0.0 ? 0.0 : std::atan2(-dy, -dx);
}

}  // namespace tandem
