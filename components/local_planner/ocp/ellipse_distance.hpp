// SPDX-License-Identifier: Apache-2.0
// In: a point and an ellipse. Out: their exact signed distance with first and second derivatives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tandem/model/obstacle.hpp"

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

/// Exact up to rounding, outside and inside. A disc of radius r ≥ 0 about p meets the filled
/// ellipse E exactly if φ(p) ≤ r: nothing is bounded, the sum of ellipse and disc is used as it is.
/// Proof: with D the closed disc of radius r about 0,
///
///   (p + D) ∩ E ≠ ∅  ⇔  |p − e| ≤ r for some e ∈ E  ⇔  p ∈ E ⊕ D  ⇔  dist(p, E) ≤ r        (4)
///
/// as D = −D, and since E is compact. Outside of E its nearest point is on the outline: φ = dist;
/// inside φ < 0 ≤ r and p itself is in both. So E ⊕ D = {φ ≤ r}, the outer parallel body of E
/// (Schneider, "Convex Bodies: The Brunn-Minkowski Theory", 2nd ed., section 3.1), and its outline
/// is the offset curve c + r n. That is no ellipse. The ellipse of semi-axes a + r and b + r lies
/// inside of it, and would hide contacts: support functions add (ibid., section 1.7), and
/// |(a cos t, b sin t)| + |(r cos t, r sin t)| ≥ |((a + r) cos t, (b + r) sin t)|.
///
/// (1) and (2): Gilbarg and Trudinger, "Elliptic Partial Differential Equations of Second Order",
/// section 14.6. Inside, beyond the centres of curvature, φ has a crease along the long axis; there
/// (2) is bounded.
///
/// `axis`: cosine and sine of the ellipse's angle, for who asks often.
[[nodiscard]] SignedDistance signed_distance_to_ellipse(const Obstacle& ellipse,
                                                        const Eigen::Vector2d& axis,
                                                        const Eigen::Vector2d& p_MQ);

/// The same, the short way for a circle.
[[nodiscard]] inline SignedDistance signed_distance(const Obstacle& ellipse,
                                                    const Eigen::Vector2d& axis,
                                                    const Eigen::Vector2d& p_MQ) {
  if (ellipse.a != ellipse.b) return signed_distance_to_ellipse(ellipse, axis, p_MQ);
  const double r = ellipse.a, x = p_MQ.x() - ellipse.p_MO.x(), y = p_MQ.y() - ellipse.p_MO.y();
  const double d2 = x * x + y * y;
  if (d2 <= 1e-18 * r * r) return {-r, {1.0, 0.0}, 2.0 / r};  // its centre has no normal
  const double d = std::sqrt(d2), per = d * (1.0 / d2);       // root and quotient at the same time
  return {d - r, {x * per, y * per}, per * r <= 2.0 ? per : 2.0 / r};
}
[[nodiscard]] inline SignedDistance signed_distance(const Obstacle& ellipse,
                                                    const Eigen::Vector2d& p_MQ) {
  return signed_distance(ellipse, {std::cos(ellipse.angle), std::sin(ellipse.angle)}, p_MQ);
}

}  // namespace tandem
