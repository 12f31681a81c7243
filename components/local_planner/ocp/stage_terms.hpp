// SPDX-License-Identifier: Apache-2.0
// Terms of one stage of an Ocp with first and second derivatives, shared by all solvers.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "tandem/local_planner/ocp/ocp.hpp"
#include "tandem/local_planner/ocp/signed_distance.hpp"

namespace tandem {

/// Cosine and sine of a heading, computed once and shared.
struct Heading {
  double c, s;

  static Heading of(double theta) { return {std::cos(theta), std::sin(theta)}; }
  [[nodiscard]] Heading turned_by(const Heading& other) const {
    return {c * other.c - s * other.s, s * other.c + c * other.s};
  }
  [[nodiscard]] Heading from(const Heading& other) const { return turned_by({other.c, -other.s}); }
};

/// Derivatives of (5) of ocp.hpp, with D the displacement, e = (cos α, sin α), n = (−sin α, cos α),
/// α = θ + γ w, S = sinc(γ w) and its derivatives S', S'':
///
///   D = v Δt S e,          D_θ = v Δt S n,              D_v = Δt S e,
///   D_w = v Δt γ (S' e + S n),     D_θθ = −v Δt S e,    D_θv = Δt S n,                       (6)
///   D_θw = v Δt γ (S' n − S e),    D_vw = Δt γ (S' e + S n),
///   D_ww = v Δt γ² (S'' e + 2 S' n − S e)
struct Displacement {
  Eigen::Vector2d d, d_theta, d_v, d_w, d_theta_theta, d_theta_v, d_theta_w, d_v_w, d_w_w;
};
[[nodiscard]] Displacement displacement(const Ocp& ocp, const Heading& theta, const Twist2& u);

/// Cost (1) of a stage without its slack term, and its derivatives. Hessian entries not listed here
/// are zero.
struct CostTerms {
  double value;
  Eigen::Vector2d u, change;  ///< gradient with respect to (v, w), (d_v, d_w)
  Eigen::Vector3d X;          ///< gradient with respect to the pose X⁺
  double vv, vw, ww;          ///< Hessian with respect to (v, w)
  Eigen::Vector2d change2;    ///< Hessian diagonal of (d_v, d_w)
  Eigen::Vector3d X2;         ///< Hessian diagonal of X⁺
  double xy;                  ///< Hessian entry of (x⁺, y⁺)
};
/// `p_MB`: position at the end of the stage; `error`: θ⁺ − θ_r.
[[nodiscard]] CostTerms cost_terms(const StageCost& cost, const Twist2& u, const Twist2& change,
                                   const Eigen::Vector2d& p_MB, const Heading& error);

/// A pose with the cosine and sine of its heading.
struct Placed {
  explicit Placed(const Pose2& X_MB) : p_MB{X_MB.position()}, theta{Heading::of(X_MB.theta)} {}
  Eigen::Vector2d p_MB;
  Heading theta;
};

/// Clearance φ(C(X)) − gap of a pair [m] and its derivatives. The disc's centre C = p + R(θ) c has
/// C_θ = R(θ) c⊥ and C_θθ = −R(θ) c, so with n = ∇φ and κ' its curvature
///
///   gradient (n, n · C_θ),   Hessian κ' l lᵀ − diag(0, 0, n · R c),   l = (n⊥, n⊥ · C_θ)     (7)
///
/// where n⊥ · C_θ = n · R c.
struct PairTerms {
  double value;
  double n_x, n_y;
  double turn;  ///< n · C_θ
  double lean;  ///< n · R c
  double curvature;

  [[nodiscard]] Eigen::Vector3d gradient() const { return {n_x, n_y, turn}; }
  [[nodiscard]] Eigen::Vector3d along() const { return {-n_y, n_x, lean}; }
  [[nodiscard]] Eigen::Matrix3d hessian() const {
    Eigen::Matrix3d H = curvature * along() * along().transpose();
    H(2, 2) -= lean;
    return H;
  }
};

[[nodiscard]] inline PairTerms pair_terms(const Pair& pair, const Placed& X) {
  const auto [c, s] = X.theta;
  const Eigen::Vector2d arm{c * pair.p_BC.x() - s * pair.p_BC.y(),
                            s * pair.p_BC.x() + c * pair.p_BC.y()};
  const SignedDistance phi = signed_distance(pair.obstacle, X.p_MB + arm);
  const Eigen::Vector2d& n = phi.normal;
  return {phi.value - pair.gap, n.x(),        n.y(), n.y() * arm.x() - n.x() * arm.y(),
          n.dot(arm),           phi.curvature};
}

}  // namespace tandem
