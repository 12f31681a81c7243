// SPDX-License-Identifier: Apache-2.0
// In: points, and what covering more than them costs. Out: the circle or ellipse around them that
// costs least.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/obstacle.hpp"
#include "obstacle_extractor/free_depth.hpp"

namespace tandem {

using Points = std::vector<Eigen::Vector2d>;

/// Convex hull, counter-clockwise from its lowest point, without points on its edges.
[[nodiscard]] Points convex_hull(Points points);

/// Shape that contains some points, and the deepest it reaches into free space [m].
struct EllipseFit {
  Obstacle shape;
  double excess = 0.0;
  double length_angle = 0.0;  ///< heading of the points' longest extent [rad]
};

/// Ellipse or circle that contains the hull, with an excess within `enough` [m] if one is found;
/// else a circle, whose `excess` then only says that it is more than enough. A circle is preferred.
/// Among ellipses along the sides of the hull's smallest rectangle, of half sides l ≥ h, each half
/// width b > h gives the shortest half length
///
///   a(b) = max over hull points (x, y) of |x| / √(1 − (y/b)²)                               (1)
///
/// and the b of least excess wins: a straight wall wants b ≈ 2 h, which overshoots its ends little,
/// not the smallest area (b = √2 h), which overshoots them by 0.41 l.
[[nodiscard]] EllipseFit fit_ellipse(const Points& hull, const FreeDepth& depth, double enough);

}  // namespace tandem
