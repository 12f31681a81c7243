// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/occupancy_plane.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "tandem/map/detail/touching.hpp"

namespace tandem {
namespace {

constexpr int kOccupiedFrom = 50, kMax = 100;                // [%]
constexpr double kSmallestCell = 1e-3, kLargestCell = 10.0;  // resolution [m], as in an OctoMap
constexpr double kFarthestOrigin = 1e6;                      // [m]
constexpr double kStraight = 0.01;  // of a cell; smaller rotations count as none

Cell cell_of(std::int8_t percent) {
  if (percent < 0 || percent > kMax) return Cell::kUnknown;
  return percent >= kOccupiedFrom ? Cell::kOccupied : Cell::kFree;
}

std::vector<Cell> cells_of(const OccupancyPlane& plane) {
  std::vector<Cell> cells(plane.percent.size());
  std::transform(plane.percent.begin(), plane.percent.end(), cells.begin(), cell_of);
  return cells;
}

// The plane as a Grid in O, to use Grid's functions.
Grid in_own_frame(const OccupancyPlane& plane) {
  return {plane.resolution, {0.0, 0.0}, plane.width, plane.height, cells_of(plane)};
}

// An unknown grid over the plane's bounding box in M, aligned with OctoMap's voxels.
Grid around(const OccupancyPlane& plane) {
  const double r = plane.resolution, w = r * plane.width, h = r * plane.height;
  Eigen::Array2d low = plane.X_MO.position(), high = low;
  for (const Eigen::Vector2d& corner : std::array<Eigen::Vector2d, 3>{{{w, 0}, {0, h}, {w, h}}}) {
    const Eigen::Array2d p = transform(plane.X_MO, corner);
    low = low.min(p);
    high = high.max(p);
  }
  const Eigen::Array2d first = (low / r + kTouching).floor();
  const Eigen::Array2d size = (high / r - kTouching).ceil() - first;
  if (!(size.prod() <= static_cast<double>(kMaxCells)))
    throw std::runtime_error("rotated by its yaw it spans more than 10⁸ cells; crop it");
  Grid grid{r, first * r, static_cast<int>(size.x()), static_cast<int>(size.y()), {}};
  grid.cells.assign(static_cast<std::size_t>(size.prod()), Cell::kUnknown);
  return grid;
}

// Marks every cell of `out` that overlaps a square cell of the plane at p_MC, rotated by c and s.
void mark(Grid& out, const Eigen::Vector2d& p_MC, double c, double s) {
  const double half = 0.5 * (1.0 + std::abs(c) + std::abs(s)) - kTouching;  // [cells]
  const Eigen::Vector2d p = (p_MC - out.origin) / out.resolution - Eigen::Vector2d{0.5, 0.5};
  const auto overlaps = [&](int ix, int iy) {  // separating axes: those of both squares
    const Eigen::Vector2d d = Eigen::Vector2d{ix, iy} - p;
    return std::max({std::abs(d.x()), std::abs(d.y()), std::abs(c * d.x() + s * d.y()),
                     std::abs(c * d.y() - s * d.x())}) < half;
  };
  for (int iy = static_cast<int>(std::ceil(p.y() - half)); iy <= p.y() + half; ++iy)
    for (int ix = static_cast<int>(std::ceil(p.x() - half)); ix <= p.x() + half; ++ix)
      if (out.contains(ix, iy) && overlaps(ix, iy)) out.cells[out.index(ix, iy)] = Cell::kOccupied;
}

void take_centers(Grid& out, const Grid& own, const Pose2& X_OM) {
  for (int iy = 0; iy < out.height; ++iy)
    for (int ix = 0; ix < out.width; ++ix) {
      const Eigen::Array2d p = transform(X_OM, out.center(ix, iy)).array() / own.resolution;
      const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
      if (own.contains(x, y)) out.cells[out.index(ix, iy)] = own.at(x, y);
    }
}

Grid turned(const OccupancyPlane& plane) {
  Grid out = around(plane);
  const Grid own = in_own_frame(plane);
  take_centers(out, own, inverse(plane.X_MO));
  const double c = std::cos(plane.X_MO.theta), s = std::sin(plane.X_MO.theta);
  for (int iy = 0; iy < own.height; ++iy)
    for (int ix = 0; ix < own.width; ++ix)
      if (own.at(ix, iy) == Cell::kOccupied)
        mark(out, transform(plane.X_MO, own.center(ix, iy)), c, s);
  return out;
}

}  // namespace

std::string error_of(const OccupancyPlane& plane) {
  if (!(plane.resolution >= kSmallestCell && plane.resolution <= kLargestCell))
    return "resolution " + std::to_string(plane.resolution) + " m outside [0.001, 10] m";
  if (!is_finite(plane.X_MO) || plane.X_MO.position().cwiseAbs().maxCoeff() > kFarthestOrigin)
    return "its origin is not finite, has a zero quaternion or is farther than 1000 km";
  if (plane.width <= 0 || plane.height <= 0 || plane.width > kMaxCells / plane.height)
    return std::to_string(plane.width) + " × " + std::to_string(plane.height) +
           " cells: must be between 1 and 10⁸";
  if (plane.percent.size() !=
      static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.height))
    return "it holds " + std::to_string(plane.percent.size()) + " cells, not " +
           std::to_string(plane.width) + " × " + std::to_string(plane.height);
  const auto is_occupied = [](std::int8_t p) { return cell_of(p) == Cell::kOccupied; };
  if (std::none_of(plane.percent.begin(), plane.percent.end(), is_occupied))
    return "the map has no occupied cell";
  return {};
}

Grid to_grid(const OccupancyPlane& plane) {
  if (const std::string error = error_of(plane); !error.empty()) throw std::runtime_error(error);
  const double turn = std::abs(wrap_angle(plane.X_MO.theta));
  if (turn * std::max(plane.width, plane.height) > kStraight) return turned(plane);
  Grid grid = in_own_frame(plane);
  grid.origin = plane.X_MO.position();
  return grid;
}

}  // namespace tandem
