// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/path_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace tandem {
namespace {

constexpr double kSpacing = 0.25;  // [m] between the points of a path

// Dijkstra's algorithm over the cells on whose centres the disc fits.
class Search {
 public:
  Search(const StaticMap& map, double radius, double narrow_cost)
      : map_{map},
        grid_{map.grid()},
        radius_{radius},
        narrow_cost_{narrow_cost},
        cost_(grid_.cells.size(), kInfinity),
        metre_(grid_.cells.size(), 0.0) {
    from_.resize(grid_.cells.size(), kNone);
  }

  [[nodiscard]] std::vector<Eigen::Vector2d> way(const Eigen::Vector2d& p_MA,
                                                 const Eigen::Vector2d& p_MZ) {
    const std::size_t start = cell_at(p_MA), goal = cell_at(p_MZ);
    if (start == kNone || goal == kNone) return {};
    reach(start, 0.0, kNone);
    while (!open_.empty() && open_.top().second != goal) {
      const auto [cost, cell] = open_.top();
      open_.pop();
      if (cost <= cost_[cell]) expand(cell);
    }
    if (cost_[goal] == kInfinity) return {};
    std::vector<Eigen::Vector2d> points{p_MZ};
    for (std::size_t cell = goal; cell != start; cell = from_[cell])
      if ((center(cell) - points.back()).norm() >= kSpacing) points.push_back(center(cell));
    points.push_back(p_MA);
    std::reverse(points.begin(), points.end());
    return points;
  }

  // Whether way() is not empty, without the cheapest.
  [[nodiscard]] bool connects(const Eigen::Vector2d& p_MA, const Eigen::Vector2d& p_MZ) {
    const std::size_t start = cell_at(p_MA), goal = cell_at(p_MZ);
    if (start == kNone || goal == kNone) return false;
    std::vector<std::size_t> open{start};
    cost_[start] = 0.0;
    while (!open.empty() && cost_[goal] == kInfinity) {
      const std::size_t cell = open.back();
      open.pop_back();
      for_each_neighbour(cell, [&](std::size_t next, double) {
        if (cost_[next] == 0.0 || metre(next) == kInfinity) return;
        cost_[next] = 0.0;  // seen
        open.push_back(next);
      });
    }
    return cost_[goal] == 0.0;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] std::size_t cell_at(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d q = (p - grid_.origin) / grid_.resolution;
    const int ix = static_cast<int>(std::floor(q.x())), iy = static_cast<int>(std::floor(q.y()));
    return grid_.contains(ix, iy) ? index(ix, iy) : kNone;
  }
  [[nodiscard]] std::size_t index(int ix, int iy) const {
    return static_cast<std::size_t>(iy) * static_cast<std::size_t>(grid_.width) +
           static_cast<std::size_t>(ix);
  }
  [[nodiscard]] Eigen::Vector2d center(std::size_t cell) const {
    const auto width = static_cast<std::size_t>(grid_.width);
    return grid_.origin +
           grid_.resolution * Eigen::Vector2d{static_cast<double>(cell % width) + 0.5,
                                              static_cast<double>(cell / width) + 0.5};
  }

  // A cell has up to eight neighbours that ask.
  double metre(std::size_t cell) {
    if (metre_[cell] == 0.0)
      metre_[cell] = cost_of_a_metre(map_, center(cell), radius_, narrow_cost_);
    return metre_[cell];
  }

  void reach(std::size_t cell, double cost, std::size_t from) {
    if (cost >= cost_[cell]) return;
    cost_[cell] = cost;
    from_[cell] = from;
    open_.push({cost, cell});
  }

  void expand(std::size_t cell) {
    for_each_neighbour(cell, [&](std::size_t next, double length) {
      reach(next, cost_[cell] + length * metre(next), cell);
    });
  }

  // Calls `visit(neighbour, distance [m])` for the cells around one.
  template <class Visit>
  void for_each_neighbour(std::size_t cell, const Visit& visit) {
    const int x = static_cast<int>(cell % static_cast<std::size_t>(grid_.width));
    const int y = static_cast<int>(cell / static_cast<std::size_t>(grid_.width));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if ((dx != 0 || dy != 0) && grid_.contains(x + dx, y + dy))
          visit(index(x + dx, y + dy), grid_.resolution * std::hypot(dx, dy));
  }

  const StaticMap& map_;
  const Grid& grid_;
  double radius_, narrow_cost_;
  std::vector<double> cost_, metre_;  // metre_: cost of a metre there; 0: not known yet
  std::vector<std::size_t> from_;
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

}  // namespace

double cost_of_a_metre(const StaticMap& map, const Eigen::Vector2d& p_MC, double radius,
                       double narrow_cost) {
  const double room = map.distance(p_MC) - radius;
  if (room < 0.0) return std::numeric_limits<double>::infinity();
  const double narrow = std::max(0.0, 1.0 - room / kWide);
  return 1.0 + narrow_cost * narrow * narrow;
}

bool has_path(const StaticMap& map, const Eigen::Vector2d& p_MA, const Eigen::Vector2d& p_MZ,
              double radius) {
  return Search{map, radius, 0.0}.connects(p_MA, p_MZ);
}

std::vector<Eigen::Vector2d> find_path(const StaticMap& map, const Eigen::Vector2d& p_MA,
                                       const Eigen::Vector2d& p_MZ, double radius,
                                       double narrow_cost) {
  return Search{map, radius, narrow_cost}.way(p_MA, p_MZ);
}

}  // namespace tandem
