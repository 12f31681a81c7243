// SPDX-License-Identifier: Apache-2.0
// In: a quadratic model of every stage. Out: the step that minimises their sum along the chain.
#pragma once

#include <Eigen/Core>
#include <span>

namespace tandem {

/// Quadratic model of one stage in the steps ΔX, Δu' at its start and Δu, ΔX⁺ at its end:
///
///   ½ (ΔX⁺, Δu)ᵀ (H + C) (ΔX⁺, Δu) + hᵀ (ΔX⁺, Δu)          cost, bounds and rows (4) of ocp.hpp
///   + ½ t Δθ² + Δθ t_uᵀ Δu                                 curvature of the motion
///   + ½ Δdᵀ D Δd + gᵀ Δd,    Δd = Δu − Δu' + e             change of the twist             (1)
///   subject to ΔX⁺ = A ΔX + B Δu + c,    A = I + (a, 0) at θ
///
/// The state at the start of a stage is (X, u'): five numbers; its controls are u: two. C, t and
/// t_u are what may be concave: C_xx of the pairs, the others of the motion.
struct ChainStage {
  Eigen::Matrix3d H_xx, C_xx;
  Eigen::Matrix<double, 3, 2> H_xu;
  Eigen::Matrix2d H_uu, C_uu;
  Eigen::Vector3d h_x;
  Eigen::Vector2d h_u;
  double t;
  Eigen::Vector2d t_u;
  Eigen::Vector2d D, g, e;
  Eigen::Vector2d a;
  Eigen::Matrix<double, 3, 2> B;
  Eigen::Vector3d c;
};

/// How much of the curvature C, t, t_u is kept, and what is added to the diagonals of H.
struct Convexity {
  double curvature = 1.0;
  double delta = 0.0;
};

/// What the recursion (2) leaves at a stage: value function at its end, and Δu = k + K ΔX + L Δu'.
struct ChainGain {
  Eigen::Matrix3d P_xx;
  Eigen::Matrix<double, 3, 2> P_xu;
  Eigen::Vector3d p_x;
  Eigen::Vector2d k;
  Eigen::Matrix<double, 2, 3> K;
  Eigen::Matrix2d L;
};

/// The step of a stage and the multipliers after it: π = −λ of rows (3), and λ of rows (2).
struct ChainStep {
  Eigen::Vector2d u, d;
  Eigen::Vector3d X;
  Eigen::Vector3d pi;
  Eigen::Vector2d lambda;
};

/// Backward pass. False if the sum of the stages is not strictly convex on the constraints: a
/// pivot of the recursion is not positive.
[[nodiscard]] bool factorize(std::span<const ChainStage> stages, const Convexity& convexity,
                             std::span<ChainGain> gains);

/// Forward pass: the minimiser and its multipliers.
void roll_out(std::span<const ChainStage> stages, std::span<const ChainGain> gains,
              std::span<ChainStep> steps);

}  // namespace tandem
