// SPDX-License-Identifier: Apache-2.0
// Private to local_planner: signed distances of several points at once, each to its own obstacle.
// One array lane per point, so that the costly square roots and divisions are vectorised.
//
// For an ellipse: with q = (|x|, |y|) in the ellipse's axes and e = a² − b², the closest point c
// follows from the one root s > 0 of
//
//   F(s) = (a q₁ / (s + e))² + (b q₂ / s)² − 1 = 0,   c = (a² q₁ / (s + e), b² q₂ / s)    (3)
//
// (Eberly, "Distance from a point to an ellipse", 2013, with t = s − b²). 0 ≤ F ≤ 1 at
// s₀ = max(b q₂, a q₁ − e). Newton's method is applied to 1 / √(1 + F) = 1 instead, as in
// trust-region methods (Conn, Gould, Toint 2000, section 7.3): the left side is increasing, concave
// and nearly linear, so the iteration from s₀ reaches the root in a few steps without overshoot.
#pragma once

#include <Eigen/Core>

namespace tandem {

template <int n>
using Lanes = Eigen::Array<double, n, 1>;

/// Points are kept off the obstacle's axes by this fraction of b, because (3) degenerates there.
inline constexpr double kOffAxes = 1e-9;

/// Distance [m], outward normal in the obstacle's axes and curvature [1/m]: (1) and (2) of
/// signed_distance.hpp.
template <int n>
struct OutlineDistance {
  Lanes<n> value, n_x, n_y, curvature;
};

template <int n>
[[nodiscard]] Lanes<n> closest_point_root(const Lanes<n>& e, const Lanes<n>& aq_x,
                                          const Lanes<n>& bq_y) {
  constexpr double kLastStep = 1e-8;  // relative; Newton's method converges quadratically
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

/// Distances of points q in the first quadrant of the ellipses' axes [m], q_x, q_y > 0; a ≥ b > 0.
template <int n>
[[nodiscard]] OutlineDistance<n> distance_to_ellipse(const Lanes<n>& a, const Lanes<n>& b,
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

/// The same, with a closed form for circles of radius r.
template <int n>
[[nodiscard]] OutlineDistance<n> distance_to_circle(const Lanes<n>& r, const Lanes<n>& q_x,
                                                    const Lanes<n>& q_y) {
  const Lanes<n> d = (q_x.square() + q_y.square()).sqrt(), per = d.inverse();
  return {d - r, q_x * per, q_y * per, per.min(2.0 / r)};
}

/// The same for rectangles |x| ≤ a, |y| ≤ b. Outside, the nearest point is on a side or at a
/// corner; inside, it is on the nearest side.
template <int n>
[[nodiscard]] OutlineDistance<n> distance_to_rectangle(const Lanes<n>& a, const Lanes<n>& b,
                                                       const Lanes<n>& q_x, const Lanes<n>& q_y) {
  constexpr double kSharpest = 20.0;        // [1/m]
  const Lanes<n> x = q_x - a, y = q_y - b;  // beyond the sides
  const Lanes<n> out_x = x.max(0.0), out_y = y.max(0.0);
  const Lanes<n> d = (out_x.square() + out_y.square()).sqrt();
  const Lanes<n> per = d.max(1e-300).inverse(), zero = Lanes<n>::Zero(), one = Lanes<n>::Ones();
  const auto is_outside = d > 0.0;
  const auto is_end_nearer = x > y;
  return {is_outside.select(d, x.max(y)),
          is_outside.select(out_x * per, is_end_nearer.select(one, zero)),
          is_outside.select(out_y * per, is_end_nearer.select(zero, one)),
          (out_x * out_y > 0.0).select(per.min(kSharpest), zero)};
}

}  // namespace tandem
