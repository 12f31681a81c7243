// SPDX-License-Identifier: Apache-2.0
// Riccati recursion: minimises the sum of the stages' quadratic models along the chain of stages.
#pragma once

#include <Eigen/Core>
#include <span>
#include <type_traits>

namespace tandem {

template <int n>
using ChainState = Eigen::Matrix<double, n, 1>;

/// Motor lag's part of a stage, with a the actual twist at its start: how the state at the stage's
/// end depends on Δa, and the motion's curvature  Δθ t_aᵀ Δa + ½ Δaᵀ C_aa Δa + Δaᵀ C_au Δu.
struct LagModel {
  Eigen::Vector2d E;              ///< Δa⁺ = E Δa + …
  Eigen::Matrix<double, 3, 2> M;  ///< Δ(x, y, θ)⁺ = M Δa + …
  Eigen::Vector2d t_a;
  Eigen::Matrix2d C_aa, C_au;
};
struct NoLag {};

/// Quadratic model of one stage in the steps ΔX, Δu' at its start and Δu, ΔX⁺ at its end:
///
///   ½ (ΔX⁺, Δu)ᵀ (H + C) (ΔX⁺, Δu) + hᵀ (ΔX⁺, Δu)          cost, bounds and rows (4) of ocp.hpp
///   + ½ t Δθ² + Δθ t_uᵀ Δu                                 curvature of the motion
///   + ½ Δdᵀ D Δd + gᵀ Δd,    Δd = Δu − Δu' + e             change of the twist             (1)
///   subject to ΔX⁺ = A ΔX + B Δu + c,    A = I + (a, 0) e_θᵀ
///
/// X is the pose (n = 3), or the pose and the actual twist (n = 5); then A contains M and E as
/// well. The state at the start of a stage is (X, u'), its control is u. Only C, t, t_u and the
/// curvature of LagModel may be concave: C_xx comes from the pairs and acts on the pose, the others
/// come from the motion.
template <int n>
struct ChainStage {
  Eigen::Matrix<double, n, n> H_xx;
  Eigen::Matrix3d C_xx;
  Eigen::Matrix<double, 3, 2> H_xu;  ///< rows of the pose
  Eigen::Matrix2d H_uu, C_uu;
  ChainState<n> h_x;
  Eigen::Vector2d h_u;
  double t;
  Eigen::Vector2d t_u;
  Eigen::Vector2d D, g, e;
  Eigen::Vector2d a;
  Eigen::Matrix<double, n, 2> B;
  ChainState<n> c;
  [[no_unique_address]] std::conditional_t<n == 5, LagModel, NoLag> lag;
};

/// Factor on the possibly concave terms, and regularisation added to the diagonals of H.
struct Convexity {
  double curvature = 1.0;
  double delta = 0.0;
};

/// Result of the recursion (2) of riccati.cpp at a stage: the value function at its end including
/// the stage's own terms, and the feedback Δu = k + K ΔX + L Δu'.
template <int n>
struct ChainGain {
  Eigen::Matrix<double, n, n> P_xx;
  Eigen::Matrix<double, n, 2> P_xu;
  ChainState<n> p_x;
  Eigen::Vector2d k;
  Eigen::Matrix<double, 2, n> K;
  Eigen::Matrix2d L;
};

/// Step of a stage and its new multipliers: π = −λ of rows (3), (8) and λ of rows (2) of ocp.hpp.
template <int n>
struct ChainStep {
  Eigen::Vector2d u, d;
  ChainState<n> X;
  ChainState<n> pi;
  Eigen::Vector2d lambda;
};

/// Backward pass. Returns false if the sum of the stages is not strictly convex on the constraints,
/// that is, if a pivot of the recursion is not positive definite. n: 3 or 5.
template <int n>
[[nodiscard]] bool factorize(std::span<const ChainStage<n>> stages, const Convexity& convexity,
                             std::span<ChainGain<n>> gains);

/// Forward pass: computes the minimiser and its multipliers.
template <int n>
void roll_out(std::span<const ChainStage<n>> stages, std::span<const ChainGain<n>> gains,
              std::span<ChainStep<n>> steps);

}  // namespace tandem
