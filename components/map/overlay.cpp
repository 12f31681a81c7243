// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/overlay.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "tandem/map/detail/touching.hpp"

namespace tandem {
namespace {

constexpr double kStep = 1.0;  // [m] step by which the square moves

struct CellSpan {
  int begin = 0, end = 0;
};

// For each of `count` cells of side `r`, starting at `low`: the cells of the other axis that it
// overlaps.
std::vector<CellSpan> overlaps(double low, double r, int count, double other_low, double other_r,
                               int other_count) {
  std::vector<CellSpan> spans(static_cast<std::size_t>(count));
  const auto clip = [&](double cell) {
    return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(other_count)));
  };
  for (int i = 0; i < count; ++i) {
    const double from = (low + i * r - other_low) / other_r, to = from + r / other_r;
    spans[static_cast<std::size_t>(i)] = {clip(std::floor(from + kTouching)),
                                          clip(std::ceil(to - kTouching))};
  }
  return spans;
}

Cell stronger(Cell a, Cell b) {
  if (a == Cell::kOccupied || b == Cell::kOccupied) return Cell::kOccupied;
  return a == Cell::kFree ? a : b;
}

}  // namespace

void lay_over(Grid& out, const Grid& in) {
  if (in.cells.empty()) return;
  const auto columns =
      overlaps(out.origin.x(), out.resolution, out.width, in.origin.x(), in.resolution, in.width);
  const auto rows =
      overlaps(out.origin.y(), out.resolution, out.height, in.origin.y(), in.resolution, in.height);
  std::size_t at = 0;
  for (const CellSpan& row : rows)
    for (const CellSpan& column : columns) {
      Cell& cell = out.cells[at++];
      for (int iy = row.begin; iy < row.end; ++iy)
        for (int ix = column.begin; ix < column.end; ++ix) cell = stronger(cell, in.at(ix, iy));
    }
}

Grid overlay(const Grid& base, const Grid& live, const Eigen::Vector2d& p_MC, double reach) {
  const double r = live.resolution;
  const double step = r * std::max(1.0, std::round(kStep / r));
  const double side = std::ceil(2.0 * reach / step + 1.0) * step, cells = std::round(side / r);
  if (!(cells * cells <= static_cast<double>(kMaxCells)))
    throw std::runtime_error("cells of " + std::to_string(r) + " m: too many within " +
                             std::to_string(reach) + " m: more than 10⁸ cells");
  Grid out;
  out.resolution = r;
  out.origin = ((p_MC.array() - reach) / step).floor() * step;
  out.width = out.height = static_cast<int>(cells);
  out.cells.assign(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height),
                   Cell::kUnknown);
  lay_over(out, base);
  lay_over(out, live);
  return out;
}

Grid with_known_ground(Grid base) {
  auto& cells = base.cells;
  if (std::find(cells.begin(), cells.end(), Cell::kFree) == cells.end())
    std::replace(cells.begin(), cells.end(), Cell::kUnknown, Cell::kFree);
  return base;
}

Grid unknown_cells(Grid grid) {
  std::replace(grid.cells.begin(), grid.cells.end(), Cell::kOccupied, Cell::kFree);
  return grid;
}

}  // namespace tandem
