// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. Bounding shapes of points: smallest rectangle, smallest circle.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/model/convex_hull.hpp"

namespace tandem {

using Points = std::vector<Eigen::Vector2d>;  // in M [m]; a `hull` is the result of convex_hull

/// Rectangle around points, turned by `angle` [rad].
struct TurnedBox {
  double angle = 0.0;
  Eigen::Vector2d along{1.0, 0.0};  ///< unit vector at that angle
  Eigen::Vector2d p_MC{0.0, 0.0};   ///< centre [m]
  Eigen::Vector2d half{0.0, 0.0};   ///< [m]

  [[nodiscard]] double area() const { return half.x() * half.y(); }
};

/// The smallest rectangle around the hull that has a side along `angle` [rad].
[[nodiscard]] TurnedBox box_along(const Points& hull, double angle);

/// The rectangle of least area; it has a side along an edge of the hull. Its longer side comes
/// first.
[[nodiscard]] TurnedBox smallest_box(const Points& hull);

struct Circle {
  Eigen::Vector2d p_MC;  ///< centre [m]
  double radius;         ///< [m]
};

/// Smallest circle around the hull up to rounding (Welzl 1991, incremental).
[[nodiscard]] Circle smallest_circle(const Points& hull);

}  // namespace tandem
