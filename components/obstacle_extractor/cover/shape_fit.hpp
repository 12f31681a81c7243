// SPDX-License-Identifier: Apache-2.0
// Finds the circle, rectangle or ellipse around points that takes the least free space.
#pragma once

#include "tandem/model/obstacle.hpp"
#include "tandem/obstacle_extractor/cover/bounding_shapes.hpp"
#include "tandem/obstacle_extractor/cover/free_space.hpp"

namespace tandem {

/// A shape that contains the given points, and its cost.
struct ShapeFit {
  Obstacle shape;
  double taken = 0.0;         ///< free space taken [m²]
  bool found = false;         ///< false: no shape is within the limits, `shape` is a circle
  double length_angle = 0.0;  ///< heading of the points' longest extent [rad]
  double first_price = 0.0;   ///< if found: the least price limit with which a shape is found [m²]
};

struct FitLimits {
  Excess excess;
  double price;         ///< maximum of the free space taken minus the bonus [m²]
  double circle_bonus;  ///< credit for a circle, as free space [m²]
};

/// Circle, rectangle or ellipse that contains the hull and takes the least free space within the
/// limits, where a circle gets `circle_bonus`. The rectangle is the hull's smallest; if next to no
/// free space is lost to it or to the circle, no ellipse is tried. Ellipses lie along the sides of
/// that rectangle, which has half sides l ≥ h, with the centre at (0, s) in it. Each half width
/// b > h + |s| gives the shortest half length
///
///   a(b, s) = max over hull points (x, y) of |x| / √(1 − ((y − s)/b)²)                      (1)
///
/// For a straight wall b ≈ 2 h is good: it overshoots the ends little, whereas the smallest area (b
/// = √2 h) overshoots them by 0.41 l. Shifting s away from the usable space makes the side facing
/// that space flatter. The best of a coarse grid over b and s is improved by a pattern search over
/// b, s and the heading (Hooke and Jeeves 1961).
[[nodiscard]] ShapeFit fit_shape(const Points& hull, const FreeSpace& space,
                                 const FitLimits& limits);

}  // namespace tandem
