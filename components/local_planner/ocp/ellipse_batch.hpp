// SPDX-License-Identifier: Apache-2.0
// Private to local_planner: the distance to an ellipse for several points at once, each with an
// ellipse of its own. A lane of an array is a point; what takes long (roots, quotients) is computed
// for all lanes by the same instructions.
//
// The closest point of an ellipse solves, with q = (|x|, |y|) in its axes and e = a² − b²,
//
//   F(s) = (a q₁ / (s + e))² + (b q₂ / s)² − 1 = 0,   c = (a² q₁ / (s + e), b² q₂ / s)    (3)
//
// for the one root s > 0 (Eberly, "Distance from a point to an ellipse", 2013, with t = s − b²).
// 0 ≤ F ≤ 1 at s₀ = max(b q₂, a q₁ − e). Newton's method is used on 1 / √(1 + F) = 1 instead, as
// trust-region methods do (Conn, Gould, Toint 2000, section 7.3): the left side rises, is concave
// and nearly straight, so that it climbs from s₀ to the root without overshoot in a few steps.
#pragma once

#include <Eigen/Core>

namespace tandem {

template <int n>
using Lanes = Eigen::Array<double, n, 1>;

/// Coordinates in the axes are at least this share of b: on the axes (3) degenerates.
inline constexpr double kOffAxes = 1e-9;

/// Value, outward normal in the axes, curvature: (1) and (2) of ellipse_distance.hpp.
template <int n>
struct OutlineDistance {
  Lanes<n> value, n_x, n_y, curvature;
};

template <int n>
[[nodiscard]] Lanes<n> closest_point_root(const Lanes<n>& e, const Lanes<n>& aq_x,
                                          const Lanes<n>& bq_y) {
  constexpr double kLastStep = 1e-8;  // relative; the next would be of its square
  Lanes<n> s = bq_y.max(aq_x - e);
  for (int i = 0; i < 60; ++i) {
    const Lanes<n> se = s + e, per_both = (se * s).inverse();
    const Lanes<n> per_first = s * per_both, per_second = se * per_both;
    const Lanes<n> f = (aq_x * per_first).square(), g = (bq_y * per_second).square();
    const Lanes<n> square = f + g;
    const Lanes<n> step =
        (square - 1.0) * square / ((1.0 + square.sqrt()) * (f * per_first + g * per_second));
    s += step;
    if (!(step > kLastStep * s).any()) break;
  }
  return s;
}

/// Of points q in the first quadrants of the axes, both coordinates positive; a ≥ b > 0.
template <int n>
[[nodiscard]] OutlineDistance<n> distance_to_outline(const Lanes<n>& a, const Lanes<n>& b,
                                                     const Lanes<n>& q_x, const Lanes<n>& q_y) {
  const Lanes<n> e = a * a - b * b, aq_x = a * q_x, bq_y = b * q_y;
  const Lanes<n> s = closest_point_root<n>(e, aq_x, bq_y);
  const Lanes<n> cos_t = aq_x / (s + e), sin_t = bq_y / s;  // (c₁ / a, c₂ / b)
  const Lanes<n> per_speed = ((a * sin_t).square() + (b * cos_t).square()).sqrt().inverse();
  const Lanes<n> n_x = b * cos_t * per_speed, n_y = a * sin_t * per_speed;
  const Lanes<n> value = n_x * (q_x - a * cos_t) + n_y * (q_y - b * sin_t);
  const Lanes<n> kappa = a * b * per_speed.cube();
  return {value, n_x, n_y, kappa / (1.0 + kappa * value).max(0.5)};  // (2)
}

/// The same, the short way for circles.
template <int n>
[[nodiscard]] OutlineDistance<n> distance_to_circle(const Lanes<n>& r, const Lanes<n>& q_x,
                                                    const Lanes<n>& q_y) {
  const Lanes<n> d = (q_x.square() + q_y.square()).sqrt(), per = d.inverse();
  return {d - r, q_x * per, q_y * per, per.min(2.0 / r)};
}

}  // namespace tandem
