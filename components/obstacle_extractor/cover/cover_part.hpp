// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. Fits one shape to a group of cells and computes its cost.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/obstacle_extractor/cover/cover.hpp"
#include "tandem/obstacle_extractor/cover/shape_fit.hpp"

namespace tandem {

using Cells = std::vector<CellIndex>;

/// Cells that one shape covers.
struct CoverPart {
  Cells cells;  ///< empty: joined into another part
  Points hull;
  double least = 0.0;         ///< no shape around the hull costs less (in units of one shape)
  ShapeFit fit;               ///< not `found` before PartFitter::fit
  Eigen::Vector2d low, high;  ///< of the hull [m]
  int changed = 0;            ///< the rearrangement round in which it last changed
};

/// Fits parts; `grid` and `space` must outlive it.
class PartFitter {
 public:
  PartFitter(const Grid& grid, const FreeSpace& space, const CoverParams& params)
      : grid_{grid}, space_{space}, params_{params} {}

  /// Cost of a circle relative to another shape; no shape costs less.
  static constexpr double kLeastCost = 0.7;

  /// Contribution of one part to (1) of cover.hpp.
  [[nodiscard]] double cost(const CoverPart& part) const {
    return (is_circle(part.fit.shape) ? kLeastCost : 1.0) +
           part.fit.taken / params_.space_per_shape;
  }

  /// Allows shapes to take more free space: the next coarseness level of cover.hpp.
  void coarsen();

  /// These cells without a shape. `least` is exact up to `most`, both in units of one shape.
  [[nodiscard]] CoverPart outline(Cells cells, double most) const;
  /// Fits the part. `fit.found` is false if the shape would cost more than `most`; the shape of a
  /// single cell is then a circle, others have none.
  void fit(CoverPart& part, double most) const;
  /// outline() and fit().
  [[nodiscard]] CoverPart fit(Cells cells, double most) const;
  /// The joined part of two, with an empty cell list.
  [[nodiscard]] CoverPart fit_both(const CoverPart& p, const CoverPart& q, double most) const;

  /// Partitions the cells by a line perpendicular to `angle` [rad] at this fraction of their
  /// extent. Neither side is empty if there is more than one cell.
  [[nodiscard]] Cells::iterator cut(Cells& cells, double angle, double fraction) const;

  /// Whether the two parts are near enough to be tried as one shape.
  [[nodiscard]] static bool neighbours(const CoverPart& p, const CoverPart& q);
  [[nodiscard]] bool contains(const CoverPart& part, const CellIndex& cell) const;

  [[nodiscard]] CoverShape shape(const CoverPart& part) const;

 private:
  [[nodiscard]] CoverPart of_hull(Cells cells, Points hull, double most) const;
  [[nodiscard]] Points corners_of_rows(const Cells& cells) const;

  const Grid& grid_;
  const FreeSpace& space_;
  CoverParams params_;
};

}  // namespace tandem
