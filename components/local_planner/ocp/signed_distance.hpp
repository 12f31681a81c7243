// SPDX-License-Identifier: Apache-2.0
// Exact signed distance from a point to an obstacle, with first and second derivatives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tandem/model/obstacle.hpp"

namespace tandem {

/// Signed distance φ(p) from a point to an obstacle's outline [m], negative inside.
///
///   ∇φ = n             outward unit normal at the closest point              (1)
///   ∇²φ = κ' t tᵀ       t ⊥ n, κ' = κ / (1 + κ φ), κ the outline's curvature  (2)
struct SignedDistance {
  double value;
  Eigen::Vector2d normal;  ///< (1)
  double curvature;        ///< κ' of (2) [1/m]
};

/// Exact up to rounding, outside and inside. A disc of radius r ≥ 0 about p intersects the filled
/// obstacle E if and only if φ(p) ≤ r: the Minkowski sum of obstacle and disc is represented
/// exactly, not by a bounding shape. Proof: with D the closed disc of radius r about 0,
///
///   (p + D) ∩ E ≠ ∅  ⇔  |p − e| ≤ r for some e ∈ E  ⇔  p ∈ E ⊕ D  ⇔  dist(p, E) ≤ r        (4)
///
/// because D = −D and E is compact. For p outside E the nearest point of E is on the outline, so
/// φ = dist; for p inside, φ < 0 ≤ r and p lies in both sets. Hence E ⊕ D = {φ ≤ r}, the outer
/// parallel body of E (Schneider, "Convex Bodies: The Brunn-Minkowski Theory", 2nd ed., section
/// 3.1). The outline of an ellipse's is the offset curve c + r n, which is not an ellipse. The
/// ellipse of semi-axes a + r and b + r lies inside it and would miss contacts: support functions
/// add (ibid., section 1.7), and
/// |(a cos t, b sin t)| + |(r cos t, r sin t)| ≥ |((a + r) cos t, (b + r) sin t)|.
///
/// (1) and (2): Gilbarg and Trudinger, "Elliptic Partial Differential Equations of Second Order",
/// section 14.6. Inside an ellipse, beyond the centres of curvature, φ has a crease along the long
/// axis; κ' is capped there, at 2κ. Inside a rectangle φ has creases where two sides are equally
/// near. Outside, κ' is 0 beside its sides and 1/φ at its corners, where it is capped at 20 / m:
/// the second derivative jumps, the first is continuous.
///
/// `axis`: cosine and sine of the obstacle's angle, so that callers can compute them once.
[[nodiscard]] SignedDistance signed_distance_in_axes(const Obstacle& obstacle,
                                                     const Eigen::Vector2d& axis,
                                                     const Eigen::Vector2d& p_MQ);

/// The same, with a closed form for circles.
[[nodiscard]] inline SignedDistance signed_distance(const Obstacle& obstacle,
                                                    const Eigen::Vector2d& axis,
                                                    const Eigen::Vector2d& p_MQ) {
  if (!is_circle(obstacle)) return signed_distance_in_axes(obstacle, axis, p_MQ);
  const double r = obstacle.a, x = p_MQ.x() - obstacle.p_MO.x(), y = p_MQ.y() - obstacle.p_MO.y();
  const double d2 = x * x + y * y;
  if (d2 <= 1e-18 * r * r) return {-r, {1.0, 0.0}, 2.0 / r};  // no unique normal at the centre
  const double d = std::sqrt(d2), per = d * (1.0 / d2);       // division need not wait for the root
  return {d - r, {x * per, y * per}, per * r <= 2.0 ? per : 2.0 / r};
}
[[nodiscard]] inline SignedDistance signed_distance(const Obstacle& obstacle,
                                                    const Eigen::Vector2d& p_MQ) {
  return signed_distance(obstacle, {std::cos(obstacle.angle), std::sin(obstacle.angle)}, p_MQ);
}

}  // namespace tandem
