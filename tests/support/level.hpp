// SPDX-License-Identifier: Apache-2.0
// A measure of where a point is relative to an obstacle's outline.
#pragma once

#include <algorithm>
#include <cmath>

#include "tandem/model/obstacle.hpp"

namespace tandem::test {

/// Below 1 inside, 1 on the outline, above 1 outside; convex in the point.
inline double level(const Obstacle& obstacle, const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d q = in_axes(obstacle, p_MQ);
  const double x = (q.x() / obstacle.a) * (q.x() / obstacle.a);
  const double y = (q.y() / obstacle.b) * (q.y() / obstacle.b);
  return is_rectangle(obstacle) ? std::max(x, y) : x + y;
}

}  // namespace tandem::test
