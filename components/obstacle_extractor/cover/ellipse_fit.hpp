// SPDX-License-Identifier: Apache-2.0
// In: points, and what covering more than them costs. Out: the circle or ellipse around them that
// costs least.
#pragma once

#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/bounding_shapes.hpp"
#include "tandem/obstacle_extractor/cover/free_space.hpp"

namespace tandem {

/// Shape that contains some points, and what it costs.
struct EllipseFit {
  Obstacle shape;
  double taken = 0.0;         ///< of the free space [m²]
  bool found = false;         ///< false: a circle beyond the limits, as all are
  double length_angle = 0.0;  ///< heading of the points' longest extent [rad]
};

struct FitLimits {
  Excess excess;
  double price;         ///< the most that a shape may take, less the bonus [m²]
  double circle_bonus;  ///< free space that being a circle is worth [m²]
};

/// Circle or ellipse that contains the hull and takes least of the free space within the limits, a
/// circle's bonus taken off. Of the ellipses along the sides of the hull's smallest rectangle, of
/// half sides l ≥ h, with centre (0, s) in it, each half width b > h + |s| gives the shortest half
/// length
///
///   a(b, s) = max over hull points (x, y) of |x| / √(1 − ((y − s)/b)²)                      (1)
///
/// A straight wall wants b ≈ 2 h, which overshoots its ends little, not the smallest area
/// (b = √2 h), which overshoots them by 0.41 l. An s away from the room makes the side towards it
/// flat, where the other side is of no use. The best of a coarse choice of b and s is improved by a
/// pattern search over b, s and the heading (Hooke and Jeeves 1961).
[[nodiscard]] EllipseFit fit_ellipse(const Points& hull, const FreeSpace& space,
                                     const FitLimits& limits);

}  // namespace tandem
