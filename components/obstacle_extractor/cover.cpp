// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/cover.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "obstacle_extractor/ellipse_fit.hpp"

namespace tandem {
namespace {

constexpr double kJoinGap = 0.25;  // [m] parts farther apart are not tried together

struct Part {
  std::vector<CellIndex> cells;
  Points hull;
  EllipseFit fit;
  Eigen::Vector2d low, high;  // of the hull [m]
};

Points corners(const Grid& grid, const CellIndex& cell) {
  const Eigen::Vector2d low = grid.origin + grid.resolution * Eigen::Vector2d(cell.ix, cell.iy);
  const double r = grid.resolution;
  return {low, {low.x() + r, low.y()}, {low.x() + r, low.y() + r}, {low.x(), low.y() + r}};
}

class Coverer {
 public:
  Coverer(const Grid& grid, const FreeDepth& depth, double max_excess)
      : grid_{grid}, depth_{depth}, max_excess_{max_excess} {}

  void split(std::vector<CellIndex> cells) {
    Part part = make(cells, convex_hull(all_corners(cells)));
    if (cells.size() == 1 || part.fit.excess <= max_excess_) {
      parts_.push_back(std::move(part));
      return;
    }
    const auto middle = halve(cells, part.fit.length_angle);
    split({cells.begin(), middle});
    split({middle, cells.end()});
  }

  // Joins pairs of neighbours as long as one shape does for both.
  void join() {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (std::size_t j = 0; j < parts_.size(); ++j) {
        if (i == j || !neighbours(parts_[i], parts_[j])) continue;
        Points points = parts_[i].hull;
        points.insert(points.end(), parts_[j].hull.begin(), parts_[j].hull.end());
        Part both = make({}, convex_hull(std::move(points)));
        if (both.fit.excess > max_excess_) continue;
        both.cells = std::move(parts_[i].cells);
        both.cells.insert(both.cells.end(), parts_[j].cells.begin(), parts_[j].cells.end());
        parts_[i] = std::move(both);
        parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(j));
        if (j < i) --i;
        j = static_cast<std::size_t>(-1);  // try all again with what this part has become
      }
  }

  // Gives every cell to the largest shape that contains it; shapes left without cells go.
  [[nodiscard]] std::vector<CoverShape> shapes() {
    std::vector<std::size_t> order(parts_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
      return parts_[i].cells.size() > parts_[j].cells.size();
    });
    std::vector<std::vector<CellIndex>> cells_of(parts_.size());
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (const CellIndex& cell : parts_[i].cells)
        cells_of[*std::find_if(order.begin(), order.end(), [&](std::size_t owner) {
          return owner == i || contains(parts_[owner], cell);
        })].push_back(cell);
    std::vector<CoverShape> result;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (!cells_of[i].empty()) result.push_back(shape(parts_[i].fit.shape, cells_of[i]));
    return result;
  }

 private:
  [[nodiscard]] Points all_corners(const std::vector<CellIndex>& cells) const {
    Points points;
    points.reserve(4 * cells.size());
    for (const CellIndex& cell : cells)
      for (const auto& p : corners(grid_, cell)) points.push_back(p);
    return points;
  }

  [[nodiscard]] Part make(std::vector<CellIndex> cells, Points hull) const {
    Part part{std::move(cells), std::move(hull), {}, {}, {}};
    part.fit = fit_ellipse(part.hull, depth_, max_excess_);
    part.low = part.high = part.hull[0];
    for (const auto& p : part.hull) {
      part.low = part.low.cwiseMin(p);
      part.high = part.high.cwiseMax(p);
    }
    return part;
  }

  // Sorts the cells into those before and behind the middle of their extent along `angle`.
  [[nodiscard]] std::vector<CellIndex>::iterator halve(std::vector<CellIndex>& cells,
                                                       double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    const auto along = [&](const CellIndex& cell) { return c * cell.ix + s * cell.iy; };
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const CellIndex& cell : cells) {
      low = std::min(low, along(cell));
      high = std::max(high, along(cell));
    }
    const auto middle = std::stable_partition(cells.begin(), cells.end(), [&](const auto& cell) {
      return along(cell) <= 0.5 * (low + high) + 1e-9;
    });
    if (middle != cells.begin() && middle != cells.end()) return middle;
    return cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / 2);
  }

  [[nodiscard]] static bool neighbours(const Part& p, const Part& q) {
    return (p.low.array() <= q.high.array() + kJoinGap).all() &&
           (q.low.array() <= p.high.array() + kJoinGap).all();
  }

  [[nodiscard]] bool contains(const Part& part, const CellIndex& cell) const {
    const Points square = corners(grid_, cell);
    return std::all_of(square.begin(), square.end(),
                       [&](const Eigen::Vector2d& p) { return level(part.fit.shape, p) <= 1.0; });
  }

  [[nodiscard]] CoverShape shape(Obstacle obstacle, const std::vector<CellIndex>& cells) const {
    CoverShape result{obstacle, grid_.center(cells[0].ix, cells[0].iy), {}};
    result.high = result.low;
    std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
    for (const CellIndex& cell : cells) {
      lowest = std::min(lowest, static_cast<std::int64_t>(cell.iy) * grid_.width + cell.ix);
      result.low = result.low.cwiseMin(grid_.center(cell.ix, cell.iy));
      result.high = result.high.cwiseMax(grid_.center(cell.ix, cell.iy));
    }
    result.obstacle.id = static_cast<std::uint32_t>(lowest + 1);
    result.low.array() -= 0.5 * grid_.resolution;
    result.high.array() += 0.5 * grid_.resolution;
    return result;
  }

  const Grid& grid_;
  const FreeDepth& depth_;
  double max_excess_;
  std::vector<Part> parts_;
};

}  // namespace

std::vector<CoverShape> cover(const Grid& grid, const std::vector<std::vector<CellIndex>>& clusters,
                              const FreeDepth& depth, double max_excess) {
  Coverer coverer(grid, depth, max_excess);
  for (const auto& cells : clusters) coverer.split(cells);
  coverer.join();
  return coverer.shapes();
}

}  // namespace tandem
