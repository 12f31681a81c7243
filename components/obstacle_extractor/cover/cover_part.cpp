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

Eigen::Vector2d lower_left(const Grid& grid, const CellIndex& cell) {
  return grid.origin + grid.resolution * Eigen::Vector2d(cell.ix, cell.iy);
}

}  // namespace

void PartFitter::coarsen() {
  params_.space_per_shape *= kMoreSpace;
  Excess& excess = params_.excess;
  excess.narrow = std::min(excess.narrow + kMoreReach, excess.open);
  outlines_.clear();
}

CoverPart PartFitter::outline(Cells cells, double most) const {
  const CellCorners corners = hull_of(cells);
  return with_outline(std::move(cells), corners, most);
}

CoverPart PartFitter::fit(Cells cells, double most) const {
  CoverPart part = outline(std::move(cells), most);
  fit(part, most);
  return part;
}

CoverPart PartFitter::fit_both(const CoverPart& p, const CoverPart& q, double most) const {
  CoverPart both = with_outline({}, hull_of_both(p.outline->corners, q.outline->corners), most);
  fit(both, most);
  return both;
}

void PartFitter::fit(CoverPart& part, double most) const {
  part.fit = {};
  const bool needs_one = part.cells.size() == 1;
  if (part.least > most && !needs_one) return;
  Outline& known = *part.outline;
  const FitLimits limits{.excess = params_.excess,
                         .price = (most - 1.0) * params_.space_per_shape,
                         .circle_bonus = (1.0 - kLeastCost) * params_.space_per_shape};
  if (known.fit.found && limits.price >= known.fit.first_price) {
    part.fit = known.fit;
    return;
  }
  const bool is_in_vain = known.fit.found || limits.price <= known.vain_limit;
  if (is_in_vain && !needs_one) return;
  part.fit = fit_shape(known.hull, space_, limits);
  if (part.fit.found)
    known.fit = part.fit;
  else
    known.vain_limit = std::max(known.vain_limit, limits.price);
}

CoverPart PartFitter::with_outline(Cells cells, const CellCorners& corners, double most) const {
  std::shared_ptr<Outline>& known = outlines_[corners];
  if (!known) known = make_outline(corners);
  const double limit = (most - kLeastCost) * params_.space_per_shape;
  if (known->taken > known->taken_limit && known->taken <= limit) {
    known->taken = space_.taken_by(known->hull, limit);
    known->taken_limit = limit;
  }
  return {std::move(cells), known, kLeastCost + known->taken / params_.space_per_shape, {}, 0};
}

std::shared_ptr<Outline> PartFitter::make_outline(const CellCorners& corners) const {
  auto outline = std::make_shared<Outline>();
  outline->corners = corners;
  outline->hull.reserve(corners.size());
  for (const CellIndex& corner : corners) outline->hull.push_back(lower_left(grid_, corner));
  outline->low = outline->high = outline->hull[0];
  for (const auto& p : outline->hull) {
    outline->low = outline->low.cwiseMin(p);
    outline->high = outline->high.cwiseMax(p);
  }
  return outline;
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
  return (p.outline->low.array() <= q.outline->high.array() + kJoinGap).all() &&
         (q.outline->low.array() <= p.outline->high.array() + kJoinGap).all();
}

bool PartFitter::contains(const CoverPart& part, const CellIndex& cell) const {
  const Eigen::Vector2d low = lower_left(grid_, cell);
  const double r = grid_.resolution;
  return tandem::contains(part.fit.shape, low) &&
         tandem::contains(part.fit.shape, {low.x() + r, low.y()}) &&
         tandem::contains(part.fit.shape, {low.x() + r, low.y() + r}) &&
         tandem::contains(part.fit.shape, {low.x(), low.y() + r});
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
