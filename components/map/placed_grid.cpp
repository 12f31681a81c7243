// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/placed_grid.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tandem {
namespace {

constexpr double kTurned = 1e-3;   // of a cell; rotations that move no corner farther are ignored
constexpr double kMeeting = 1e-6;  // of a cell; a common edge is not an overlap

double diameter(const Grid& grid) { return grid.resolution * std::hypot(grid.width, grid.height); }

// An empty grid of M that contains the whole placed grid, aligned with OctoMap's cells.
Grid frame_of(const Grid& grid, const Pose2& X_MF, double spread) {
  const double r = grid.resolution;
  const Eigen::Vector2d size = r * Eigen::Vector2d(grid.width, grid.height);
  Eigen::Array2d low = transform(X_MF, grid.origin).array(), high = low;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(size.x(), 0.0), Eigen::Vector2d(0.0, size.y()), size}) {
    const Eigen::Array2d p = transform(X_MF, grid.origin + corner).array();
    low = low.min(p);
    high = high.max(p);
  }
  const Eigen::Array2d first = ((low - spread) / r).floor(), last = ((high + spread) / r).ceil();
  const Eigen::Array2d cells = last - first;
  if (!(cells.prod() <= static_cast<double>(kMaxCells)))
    throw std::runtime_error("rotated into the map's frame it has more than 10⁸ cells");
  Grid out;
  out.resolution = r;
  out.origin = (first * r).matrix();
  out.width = static_cast<int>(cells.x());
  out.height = static_cast<int>(cells.y());
  out.cells.assign(static_cast<std::size_t>(cells.prod()), Cell::kUnknown);
  return out;
}

// Finds what the cells of a grid of M overlap in the grid of F. Lengths in cells, along F's axes.
class Overlap {
 public:
  Overlap(const Grid& grid, const Pose2& X_MF, double spread)
      : grid_{grid},
        c_{std::abs(std::cos(X_MF.theta))},
        s_{std::abs(std::sin(X_MF.theta))},
        cosine_{std::cos(X_MF.theta)},
        sine_{std::sin(X_MF.theta)},
        half_{0.5 + spread / grid.resolution},
        X_FM_{inverse(X_MF)} {}

  // The state with the highest precedence among the cells that overlap the cell with this centre.
  [[nodiscard]] Cell of(const Eigen::Vector2d& p_MC) const {
    const Eigen::Vector2d p = (transform(X_FM_, p_MC) - grid_.origin) / grid_.resolution;
    const double reach = half_ + 0.5 * (c_ + s_) - kMeeting;
    const int left = first(p.x(), reach), right = last(p.x(), reach);
    const int low = first(p.y(), reach), high = last(p.y(), reach);
    Cell found =
        grid_.contains(left, low) && grid_.contains(right, high) ? Cell::kFree : Cell::kUnknown;
    for (int iy = std::max(low, 0); iy <= std::min(high, grid_.height - 1); ++iy)
      for (int ix = std::max(left, 0); ix <= std::min(right, grid_.width - 1); ++ix) {
        const Cell cell = grid_.at(ix, iy);
        if (cell == Cell::kFree || cell == found || !meets(ix + 0.5 - p.x(), iy + 0.5 - p.y()))
          continue;
        if (cell == Cell::kOccupied) return cell;
        found = cell;
      }
    return found;
  }

 private:
  // Indices of the cells whose centres are less than `reach` away along an axis.
  static int first(double p, double reach) { return static_cast<int>(std::ceil(p - 0.5 - reach)); }
  static int last(double p, double reach) { return static_cast<int>(std::floor(p - 0.5 + reach)); }

  // Whether the grown square at (dx, dy) and the rotated one overlap along M's axes; along F's axes
  // they do.
  [[nodiscard]] bool meets(double dx, double dy) const {
    const double reach = 0.5 + half_ * (c_ + s_) - kMeeting;
    return std::abs(cosine_ * dx - sine_ * dy) < reach &&
           std::abs(sine_ * dx + cosine_ * dy) < reach;
  }

  const Grid& grid_;
  double c_, s_, cosine_, sine_, half_;
  Pose2 X_FM_;
};

}  // namespace

Grid placed(Grid grid, const Pose2& X_MF, double spread) {
  const double farthest = diameter(grid) + grid.origin.norm();
  if (spread == 0.0 && std::abs(X_MF.theta) * farthest <= kTurned * grid.resolution) {
    grid.origin += X_MF.position();
    return grid;
  }
  if (grid.cells.empty()) return grid;
  Grid out = frame_of(grid, X_MF, spread);
  const Overlap overlap{grid, X_MF, spread};
  std::size_t at = 0;
  for (int iy = 0; iy < out.height; ++iy)
    for (int ix = 0; ix < out.width; ++ix) out.cells[at++] = overlap.of(out.center(ix, iy));
  return out;
}

}  // namespace tandem
