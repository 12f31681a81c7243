// SPDX-License-Identifier: Apache-2.0
// In: a point and an ellipse. Out: their exact signed distance with first and second derivatives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "model/obstacle.hpp"

namespace tandem {

/// Signed distance φ(p) from a point to an ellipse's outline [m], negative inside.
///
///   ∇φ = n             outward unit normal at the closest point              (1)
///   ∇²φ = κ' t tᵀ       t ⊥ n, κ' = κ / (1 + κ φ), κ the outline's curvature  (2)
struct SignedDistance {
  double value;
  Eigen::Vector2d normal;  ///< (1)
  double curvature;        ///< κ' of (2) [1/m]
};

/// Exact up to rounding, outside and inside. A disc of radius r about p keeps clear of the ellipse
/// exactly if value > r: the Minkowski sum of the two, which is no ellipse, is {φ ≤ r}. Inside,
/// beyond the centres of curvature, φ has a crease along the long axis; there (2) is bounded.
[[nodiscard]] SignedDistance signed_distance_to_ellipse(const Obstacle& ellipse,
                                                        const Eigen::Vector2d& p_MQ);

/// The same, the short way for a circle.
[[nodiscard]] inline SignedDistance signed_distance(const Obstacle& ellipse,
                                                    const Eigen::Vector2d& p_MQ) {
  if (ellipse.a != ellipse.b) return signed_distance_to_ellipse(ellipse, p_MQ);
  const double r = ellipse.a, x = p_MQ.x() - ellipse.p_MO.x(), y = p_MQ.y() - ellipse.p_MO.y();
  const double d2 = x * x + y * y;
  if (d2 <= 1e-18 * r * r) return {-r, {1.0, 0.0}, 2.0 / r};  // its centre has no normal
  const double d = std::sqrt(d2), per = d * (1.0 / d2);       // root and quotient at the same time
  return {d - r, {x * per, y * per}, per * r <= 2.0 ? per : 2.0 / r};
}

}  // namespace tandem
