// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/stage_terms.hpp"

namespace tandem {
namespace {

using Eigen::Vector2d;

struct Sinc {
  double value, first, second;
};

// sinc and its derivatives at b. `turn`: cosine and sine of b.
Sinc sinc(double b, const Heading& turn) {
  const double b2 = b * b;
  if (std::abs(b) < 0.02)
    return {1.0 - b2 / 6.0 * (1.0 - b2 / 20.0), -b / 3.0 * (1.0 - b2 / 10.0 * (1.0 - b2 / 28.0)),
            -1.0 / 3.0 + b2 / 10.0 * (1.0 - b2 * 10.0 / 168.0)};
  const double value = turn.s / b, first = (turn.c - value) / b;
  return {value, first, -value - 2.0 * first / b};
}

// Krijnen's direction term as a smooth function of the twist: 2 (1 − (v cos δ + w sin δ) / r) with
// r² = v² + w² + ε². For v > 0 the direction of (v, w) is his atan(w / v); up to ε both terms
// vanish at the same twists.
struct DirectionCost {
  double value;
  Vector2d gradient;
  double vv, vw, ww;
};

DirectionCost direction_cost(const Twist2& u, double direction) {
  constexpr double kEpsilon2 = 0.05 * 0.05;  // [m²/s²] near standstill (v, w) has no direction
  const double c = std::cos(direction), s = std::sin(direction);
  const double r2 = u.v * u.v + u.w * u.w + kEpsilon2, r = std::sqrt(r2);
  const double along = u.v * c + u.w * s, r3 = r2 * r, k = 3.0 * along / r2;
  return {2.0 - 2.0 * along / r,
          {-2.0 * (c / r - along * u.v / r3), -2.0 * (s / r - along * u.w / r3)},
          2.0 * (2.0 * c * u.v + along - k * u.v * u.v) / r3,
          2.0 * (c * u.w + s * u.v - k * u.v * u.w) / r3,
          2.0 * (2.0 * s * u.w + along - k * u.w * u.w) / r3};
}

void add_direction_cost(const StageCost& c, const Twist2& u, CostTerms& terms) {
  const DirectionCost toward = direction_cost(u, c.direction);
  terms.value += c.c_dir * toward.value;
  terms.u += c.c_dir * toward.gradient;
  terms.vv += c.c_dir * toward.vv;
  terms.vw += c.c_dir * toward.vw;
  terms.ww += c.c_dir * toward.ww;
}

}  // namespace

Displacement displacement(const Ocp& ocp, const Heading& theta, const Twist2& u) {
  const double g = ocp.half, b = g * u.w, length = u.v * ocp.dt;
  const Heading turn = b == 0.0 ? Heading{1.0, 0.0} : Heading::of(b);
  const Sinc s = sinc(b, turn);
  const Heading alpha = theta.turned_by(turn);
  const Vector2d e{alpha.c, alpha.s}, n{-e.y(), e.x()};
  const Vector2d bend = g * (s.first * e + s.value * n);
  return {.d = length * s.value * e,
          .d_theta = length * s.value * n,
          .d_v = ocp.dt * s.value * e,
          .d_w = length * bend,
          .d_theta_theta = -length * s.value * e,
          .d_theta_v = ocp.dt * s.value * n,
          .d_theta_w = length * g * (s.first * n - s.value * e),
          .d_v_w = ocp.dt * bend,
          .d_w_w = length * g * g * (s.second * e + 2.0 * s.first * n - s.value * e)};
}

CostTerms cost_terms(const StageCost& c, const Twist2& u, const Twist2& change,
                     const Vector2d& p_MB, const Heading& error) {
  const Vector2d e = p_MB - c.X_MR.position(), pull = c.pull(e);
  const double e_v = u.v - c.twist.v, e_w = u.w - c.twist.w;
  const double e_dv = change.v - c.change.v, e_dw = change.w - c.change.w;
  CostTerms terms{.value = e.dot(pull) + 2.0 * c.q_theta * (1.0 - error.c) + c.r_v * e_v * e_v +
                           c.r_w * e_w * e_w + c.c_v * e_dv * e_dv + c.c_w * e_dw * e_dw,
                  .u = {2.0 * c.r_v * e_v, 2.0 * c.r_w * e_w},
                  .change = {2.0 * c.c_v * e_dv, 2.0 * c.c_w * e_dw},
                  .X = {2.0 * pull.x(), 2.0 * pull.y(), 2.0 * c.q_theta * error.s},
                  .vv = 2.0 * c.r_v,
                  .vw = 0.0,
                  .ww = 2.0 * c.r_w,
                  .change2 = {2.0 * c.c_v, 2.0 * c.c_w},
                  .X2 = {2.0 * c.q_x, 2.0 * c.q_y, 2.0 * c.q_theta * error.c},
                  .xy = 2.0 * c.q_xy};
  if (c.c_dir > 0.0) add_direction_cost(c, u, terms);
  return terms;
}

}  // namespace tandem
