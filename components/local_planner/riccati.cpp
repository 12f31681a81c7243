// SPDX-License-Identifier: Apache-2.0
// With W = H + C + δI + P the value function of (ΔX⁺, Δu), and ΔX⁺ put in:
//
//   Q_uu = BᵀW_xx B + BᵀW_xu + W_xuᵀB + W_uu + D,   Q_xu = Aᵀ(W_xx B + W_xu) + e_θ t_uᵀ
//   Q_xx = AᵀW_xx A + t e_θ e_θᵀ,                   Q_u'u = −D,   Q_u'u' = D                 (2)
//   P = Q − (Q_xu; −D) Q_uu⁻¹ (Q_xu; −D)ᵀ
//
// The pivots are the Q_uu, 2 × 2. All of them are positive exactly if the matrix of the whole
// system has as many positive eigenvalues as it has variables: the inertia that Ipopt asks for.
#include "local_planner/riccati.hpp"

namespace tandem {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix32 = Eigen::Matrix<double, 3, 2>;

// Value function of (X, u') at the start of a stage.
struct Value {
  Matrix3d xx = Matrix3d::Zero();
  Matrix32 xu = Matrix32::Zero();
  Matrix2d uu = Matrix2d::Zero();
  Vector3d x = Vector3d::Zero();
  Vector2d u = Vector2d::Zero();
};

// Adds the stage's own terms: then V is W.
void add(const ChainStage& s, const Convexity& convexity, Value& V) {
  V.xx += s.H_xx + convexity.curvature * s.C_xx;
  V.xx.diagonal().array() += convexity.delta;
  V.xu += s.H_xu;
  V.uu += s.H_uu + convexity.curvature * s.C_uu;
  V.uu.diagonal().array() += convexity.delta;
  V.x += s.h_x;
  V.u += s.h_u;
}

// Aᵀ M: the row of θ gathers those of the position.
template <class Matrix>
Matrix before(const Vector2d& a, const Matrix& M) {
  Matrix out = M;
  out.row(2) += a.x() * M.row(0) + a.y() * M.row(1);
  return out;
}

// False unless M is safely positive definite.
bool invert(const Matrix2d& M, Matrix2d& inverse) {
  const double product = M(0, 0) * M(1, 1), determinant = product - M(1, 0) * M(1, 0);
  if (!(M(0, 0) > 0.0 && determinant > 1e-12 * product)) return false;
  const double per = 1.0 / determinant;
  inverse << per * M(1, 1), -per * M(1, 0), -per * M(1, 0), per * M(0, 0);
  return true;
}

// One step of (2). V: of the end of the stage when called, of its start afterwards.
bool recede(const ChainStage& s, const Convexity& convexity, Value& V, ChainGain& gain) {
  add(s, convexity, V);
  gain.P_xx = V.xx;
  gain.P_xu = V.xu;
  gain.p_x = V.x;

  const Matrix32 T = V.xx * s.B + V.xu;
  Matrix2d Q_uu = s.B.transpose() * T + V.xu.transpose() * s.B + V.uu;
  Q_uu.diagonal() += s.D;
  Matrix2d inverse;
  if (!invert(Q_uu, inverse)) return false;
  Matrix32 Q_xu = before(s.a, T);
  Q_xu.row(2) += convexity.curvature * s.t_u.transpose();
  Matrix3d Q_xx = before(s.a, V.xx);
  Q_xx.col(2) += Q_xx.leftCols<2>() * s.a;
  Q_xx(2, 2) += convexity.curvature * s.t;

  const Vector3d x_after = V.x + V.xx * s.c;
  const Vector2d g = s.g + s.D.cwiseProduct(s.e);
  const Vector2d q_u = s.B.transpose() * x_after + V.u + V.xu.transpose() * s.c + g;
  gain.k = -inverse * q_u;
  gain.K = -inverse * Q_xu.transpose();
  gain.L = inverse * s.D.asDiagonal();

  V.xx = Q_xx + Q_xu * gain.K;
  V.xu = Q_xu * gain.L;
  V.uu = -(s.D.asDiagonal() * gain.L);
  V.uu.diagonal() += s.D;
  V.x = before(s.a, x_after) + Q_xu * gain.k;
  V.u = -g - s.D.cwiseProduct(gain.k);
  return true;
}

}  // namespace

bool factorize(std::span<const ChainStage> stages, const Convexity& convexity,
               std::span<ChainGain> gains) {
  Value V;
  for (std::size_t k = stages.size(); k-- > 0;)
    if (!recede(stages[k], convexity, V, gains[k])) return false;
  return true;
}

void roll_out(std::span<const ChainStage> stages, std::span<const ChainGain> gains,
              std::span<ChainStep> steps) {
  Vector3d X = Vector3d::Zero();
  Vector2d u = Vector2d::Zero();
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const ChainStage& s = stages[k];
    const ChainGain& gain = gains[k];
    ChainStep& step = steps[k];
    step.u = gain.k + gain.K * X + gain.L * u;
    step.d = step.u - u + s.e;
    step.X = X + s.B * step.u + s.c;
    step.X.head<2>() += X.z() * s.a;
    step.pi = gain.P_xx * step.X + gain.P_xu * step.u + gain.p_x;
    step.lambda = s.g + s.D.cwiseProduct(step.d);
    X = step.X;
    u = step.u;
  }
}

}  // namespace tandem
