// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. Fits one shape to a group of cells and computes its cost.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <unordered_map>

#include "tandem/map/grid.hpp"
#include "tandem/obstacle_extractor/cover/cell_hull.hpp"
#include "tandem/obstacle_extractor/cover/cover.hpp"
#include "tandem/obstacle_extractor/cover/shape_fit.hpp"

namespace tandem {

/// The convex hull of a part's cells, and what a fitter has computed of it: rearranging comes back
/// to two of three hulls.
struct Outline {
  static constexpr double kNone = -std::numeric_limits<double>::infinity();

  CellCorners corners;
  Points hull;                 ///< the same [m]
  Eigen::Vector2d low, high;   ///< of the hull [m]
  double taken = 0.0;          ///< free space that the hull takes [m²], exact up to `taken_limit`
  double taken_limit = kNone;  ///< [m²]
  ShapeFit fit;                ///< the best shape, once one was found
  double vain_limit = kNone;   ///< of the price, with which none was found [m²]
};

/// Cells that one shape covers.
struct CoverPart {
  Cells cells;  ///< empty: joined into another part
  std::shared_ptr<Outline> outline;
  double least = 0.0;  ///< no shape around the hull costs less (in units of one shape)
  ShapeFit fit;        ///< not `found` before PartFitter::fit
  int changed = 0;     ///< the rearrangement round in which it last changed
};

/// Fits parts; `grid` and `space` must outlive it. Keeps what it has computed; for one thread.
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
  [[nodiscard]] CoverPart with_outline(Cells cells, const CellCorners& corners, double most) const;
  [[nodiscard]] std::shared_ptr<Outline> make_outline(const CellCorners& corners) const;

  const Grid& grid_;
  const FreeSpace& space_;
  CoverParams params_;
  mutable std::unordered_map<CellCorners, std::shared_ptr<Outline>, HashOfCorners> outlines_;
};

}  // namespace tandem
