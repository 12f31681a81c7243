// SPDX-License-Identifier: Apache-2.0
// The closest point of an ellipse solves, with q = (|x|, |y|) in its axes and e = a² − b²,
//
//   F(s) = (a q₁ / (s + e))² + (b q₂ / s)² − 1 = 0,   c = (a² q₁ / (s + e), b² q₂ / s)    (3)
//
// for the one root s > 0 (Eberly, "Distance from a point to an ellipse", 2013, with t = s − b²).
// 0 ≤ F ≤ 1 at s₀ = max(b q₂, a q₁ − e). Newton's method is used on 1 / √(1 + F) = 1 instead, as
// trust-region methods do (Conn, Gould, Toint 2000, section 7.3): the left side rises, is concave
// and nearly straight, so that it climbs from s₀ to the root without overshoot in a few steps.
#include "local_planner/ellipse_distance.hpp"

#include <algorithm>
#include <cmath>

namespace tandem {
namespace {

double closest_point_root(double a, double b, const Eigen::Vector2d& q) {
  const double e = a * a - b * b, m = a * q.x(), n = b * q.y();
  double s = std::max(n, m - e);
  for (int i = 0; i < 60; ++i) {
    const double per_first = 1.0 / (s + e), per_second = 1.0 / s;
    const double f = m * per_first, g = n * per_second, square = f * f + g * g;
    const double value = square - 1.0;
    if (value <= 1e-15) break;
    const double step =
        value * square / ((1.0 + std::sqrt(square)) * (f * f * per_first + g * g * per_second));
    s += step;
    if (step <= 1e-15 * s) break;
  }
  return s;
}

// Of a point q in the first quadrant of the axes, both coordinates positive.
SignedDistance in_first_quadrant(double a, double b, const Eigen::Vector2d& q) {
  const double s = closest_point_root(a, b, q);                                  // (3)
  const double cos_t = std::min(1.0, a * q.x() / (s + a * a - b * b));           // c₁ / a
  const double sin_t = std::sqrt(std::max(0.0, (1.0 - cos_t) * (1.0 + cos_t)));  // c₂ / b
  const double speed = std::sqrt(a * a * sin_t * sin_t + b * b * cos_t * cos_t);
  const Eigen::Vector2d normal{b * cos_t / speed, a * sin_t / speed};
  const double value = normal.dot(q - Eigen::Vector2d{a * cos_t, b * sin_t});
  const double kappa = a * b / (speed * speed * speed);
  return {value, normal, kappa / std::max(0.5, 1.0 + kappa * value)};  // (2)
}

}  // namespace

SignedDistance signed_distance_to_ellipse(const Obstacle& ellipse, const Eigen::Vector2d& p_MQ) {
  const double c = std::cos(ellipse.angle), s = std::sin(ellipse.angle);
  const Eigen::Vector2d d_M = p_MQ - ellipse.p_MO;
  const Eigen::Vector2d p{c * d_M.x() + s * d_M.y(), c * d_M.y() - s * d_M.x()};
  const double tiny = 1e-9 * ellipse.b;  // keeps off the axes, where (3) degenerates
  const Eigen::Vector2d q = p.cwiseAbs().cwiseMax(tiny);
  SignedDistance d = in_first_quadrant(ellipse.a, ellipse.b, q);
  const Eigen::Vector2d n{std::copysign(d.normal.x(), p.x()), std::copysign(d.normal.y(), p.y())};
  d.normal = {c * n.x() - s * n.y(), s * n.x() + c * n.y()};
  return d;
}

}  // namespace tandem
