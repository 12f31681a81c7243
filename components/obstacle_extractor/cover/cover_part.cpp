// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/cover_part.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace tandem {
namespace {

constexpr double kJoinGap = 0.8;  // [m] maximum distance of two parts that are joined
// Increase per coarseness level.
constexpr double kMoreSpace = 1.15, kMoreReach = 0.03;  // [-], [m]

Points corners(const Grid& grid, const CellIndex& cell) {
  const Eigen::Vector2d low = grid.origin + grid.resolution * Eigen::Vector2d(cell.ix, cell.iy);
  const double r = grid.resolution;
  return {low, {low.x() + r, low.y()}, {low.x() + r, low.y() + r}, {low.x(), low.y() + r}};
}

}  // namespace

void PartFitter::coarsen() {
  params_.space_per_shape *= kMoreSpace;
  Excess& excess = params_.excess;
  excess.narrow = std::min(excess.narrow + kMoreReach, excess.open);
}

CoverPart PartFitter::outline(Cells cells, double most) const {
  Points hull = convex_hull(corners_of_rows(cells));
  return of_hull(std::move(cells), std::move(hull), most);
}

CoverPart PartFitter::fit(Cells cells, double most) const {
  CoverPart part = outline(std::move(cells), most);
  fit(part, most);
  return part;
}

CoverPart PartFitter::fit_both(const CoverPart& p, const CoverPart& q, double most) const {
  Points points = p.hull;
  points.insert(points.end(), q.hull.begin(), q.hull.end());
  CoverPart both = of_hull({}, convex_hull(std::move(points)), most);
  fit(both, most);
  return both;
}

void PartFitter::fit(CoverPart& part, double most) const {
  part.fit = {};
  if (part.least > most && part.cells.size() != 1) return;
  part.fit = fit_shape(part.hull, space_,
                       {.excess = params_.excess,
                        .price = (most - 1.0) * params_.space_per_shape,
                        .circle_bonus = (1.0 - kLeastCost) * params_.space_per_shape});
}

CoverPart PartFitter::of_hull(Cells cells, Points hull, double most) const {
  CoverPart part{std::move(cells), std::move(hull), 0.0, {}, {}, {}, 0};
  const double worth = params_.space_per_shape;
  part.least = kLeastCost + space_.taken_by(part.hull, (most - kLeastCost) * worth) / worth;
  part.low = part.high = part.hull[0];
  for (const auto& p : part.hull) {
    part.low = part.low.cwiseMin(p);
    part.high = part.high.cwiseMax(p);
  }
  return part;
}

// Corners of the first and last cell of each row; only these can be on the hull.
Points PartFitter::corners_of_rows(const Cells& cells) const {
  const auto [low, high] = std::minmax_element(
      cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.iy < b.iy; });
  struct Row {
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
  };
  const int bottom = low->iy;
  std::vector<Row> rows(static_cast<std::size_t>(high->iy - bottom + 1));
  for (const CellIndex& cell : cells) {
    Row& row = rows[static_cast<std::size_t>(cell.iy - bottom)];
    row.first = std::min(row.first, cell.ix);
    row.last = std::max(row.last, cell.ix);
  }
  Points points;
  points.reserve(8 * rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].first > rows[i].last) continue;
    const int iy = bottom + static_cast<int>(i);
    for (const int ix : {rows[i].first, rows[i].last})
      for (const auto& p : corners(grid_, {ix, iy})) points.push_back(p);
  }
  return points;
}

Cells::iterator PartFitter::cut(Cells& cells, double angle, double fraction) const {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto along = [&](const CellIndex& cell) { return c * cell.ix + s * cell.iy; };
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const CellIndex& cell : cells) {
    low = std::min(low, along(cell));
    high = std::max(high, along(cell));
  }
  const double line = low + fraction * (high - low) + 1e-9;
  const auto middle = std::stable_partition(cells.begin(), cells.end(),
                                            [&](const auto& cell) { return along(cell) <= line; });
  if (middle != cells.begin() && middle != cells.end()) return middle;
  return cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / 2);
}

bool PartFitter::neighbours(const CoverPart& p, const CoverPart& q) {
  return (p.low.array() <= q.high.array() + kJoinGap).all() &&
         (q.low.array() <= p.high.array() + kJoinGap).all();
}

bool PartFitter::contains(const CoverPart& part, const CellIndex& cell) const {
  const Points square = corners(grid_, cell);
  return std::all_of(square.begin(), square.end(),
                     [&](const Eigen::Vector2d& p) { return tandem::contains(part.fit.shape, p); });
}

CoverShape PartFitter::shape(const CoverPart& part) const {
  const CellIndex& first = part.cells[0];
  CoverShape result{part.fit.shape, grid_.center(first.ix, first.iy), {}};
  result.high = result.low;
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  for (const CellIndex& cell : part.cells) {
    lowest = std::min(lowest, static_cast<std::int64_t>(cell.iy) * grid_.width + cell.ix);
    result.low = result.low.cwiseMin(grid_.center(cell.ix, cell.iy));
    result.high = result.high.cwiseMax(grid_.center(cell.ix, cell.iy));
  }
  result.obstacle.id = static_cast<std::uint32_t>(lowest + 1);
  result.low.array() -= 0.5 * grid_.resolution;
  result.high.array() += 0.5 * grid_.resolution;
  return result;
}

}  // namespace tandem
