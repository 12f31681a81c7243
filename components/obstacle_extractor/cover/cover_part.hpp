// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. In: cells. Out: the shape that covers them, and what it costs.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/obstacle_extractor/cover/cover.hpp"
#include "tandem/obstacle_extractor/cover/ellipse_fit.hpp"

namespace tandem {

using Cells = std::vector<CellIndex>;

/// Cells that one shape covers.
struct CoverPart {
  Cells cells;  ///< none: joined into another
  Points hull;
  EllipseFit fit;
  Eigen::Vector2d low, high;  ///< of the hull [m]
  int changed = 0;            ///< the round after which it is as it is
};

/// Makes parts; `grid` and `space` have to outlive it.
class PartFitter {
 public:
  PartFitter(const Grid& grid, const FreeSpace& space, const CoverParams& params)
      : grid_{grid}, space_{space}, params_{params} {}

  /// A circle's cost in shapes; no shape costs less.
  static constexpr double kLeastCost = 0.7;

  /// Share of one part in (1) of cover.hpp.
  [[nodiscard]] double cost(const CoverPart& part) const {
    const bool is_circle = part.fit.shape.a == part.fit.shape.b;
    return (is_circle ? kLeastCost : 1.0) + part.fit.taken / params_.space_per_shape;
  }

  /// From now on shapes may take more: a level of cover.hpp.
  void coarsen();

  /// The part of these cells. It is found only if it costs at most `most` shapes.
  [[nodiscard]] CoverPart fit(Cells cells, double most) const;
  /// The part that two will be together, still without its cells.
  [[nodiscard]] CoverPart fit_both(const CoverPart& p, const CoverPart& q, double most) const;

  /// Sorts the cells into those before and behind a line across `angle` [rad], at this fraction of
  /// their extent. Both have some if there is more than one cell.
  [[nodiscard]] Cells::iterator cut(Cells& cells, double angle, double fraction) const;

  /// Whether they are near enough for one shape.
  [[nodiscard]] static bool neighbours(const CoverPart& p, const CoverPart& q);
  [[nodiscard]] bool contains(const CoverPart& part, const CellIndex& cell) const;

  [[nodiscard]] CoverShape shape(const CoverPart& part) const;

 private:
  [[nodiscard]] CoverPart make(Cells cells, Points hull, double most) const;
  [[nodiscard]] Points corners_of_rows(const Cells& cells) const;

  const Grid& grid_;
  const FreeSpace& space_;
  CoverParams params_;
};

}  // namespace tandem
