// SPDX-License-Identifier: Apache-2.0
// The convex hull of points in the plane.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tandem {

/// Convex hull of at least one point, counter-clockwise from its lowest point (smallest y, of these
/// the smallest x), without points on its edges.
[[nodiscard]] std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);

}  // namespace tandem
