// SPDX-License-Identifier: Apache-2.0
// With W = H + C + δI + P the value function of (ΔX⁺, Δu), substituting ΔX⁺ gives
//
//   Q_uu = BᵀW_xx B + BᵀW_xu + W_xuᵀB + W_uu + D,   Q_xu = Aᵀ(W_xx B + W_xu) + e_θ t_uᵀ
//   Q_xx = AᵀW_xx A + t e_θ e_θᵀ,                   Q_u'u = −D,   Q_u'u' = D                 (2)
//   P = Q − (Q_xu; −D) Q_uu⁻¹ (Q_xu; −D)ᵀ
//
// The pivots are the 2 × 2 matrices Q_uu. All of them are positive definite if and only if the KKT
// matrix has as many positive eigenvalues as there are variables, the inertia that Ipopt requires.
#include "tandem/local_planner/solvers/riccati.hpp"

namespace tandem {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
// Value function of (X, u') at the start of a stage.
template <int n>
struct Value {
  Eigen::Matrix<double, n, n> xx = Eigen::Matrix<double, n, n>::Zero();
  Eigen::Matrix<double, n, 2> xu = Eigen::Matrix<double, n, 2>::Zero();
  Matrix2d uu = Matrix2d::Zero();
  ChainState<n> x = ChainState<n>::Zero();
  Vector2d u = Vector2d::Zero();
};

// Adds the stage's own terms, which turns V from P into W of (2).
template <int n>
void add(const ChainStage<n>& s, const Convexity& convexity, Value<n>& V) {
  if constexpr (n == 3) {
    V.xx += s.H_xx + convexity.curvature * s.C_xx;
  } else {
    V.xx += s.H_xx;
    V.xx.template topLeftCorner<3, 3>() += convexity.curvature * s.C_xx;
  }
  V.xx.diagonal().array() += convexity.delta;
  V.xu.template topRows<3>() += s.H_xu;
  V.uu += s.H_uu + convexity.curvature * s.C_uu;
  V.uu.diagonal().array() += convexity.delta;
  V.x += s.h_x;
  V.u += s.h_u;
}

// Aᵀ M, exploiting that A differs from I only in the column of θ and the columns of the twist.
template <int n, class Matrix>
Matrix before(const ChainStage<n>& s, const Matrix& M) {
  Matrix out = M;
  out.row(2) += s.a.x() * M.row(0) + s.a.y() * M.row(1);
  if constexpr (n == 5)
    out.template bottomRows<2>() = s.lag.M.transpose() * M.template topRows<3>() +
                                   s.lag.E.asDiagonal() * out.template bottomRows<2>();
  return out;
}

// Adds the curvature of the motion, which acts on the state at the start of the stage.
template <int n>
void add_motion(const ChainStage<n>& s, double curvature, Eigen::Matrix<double, n, n>& Q_xx,
                Eigen::Matrix<double, n, 2>& Q_xu) {
  Q_xu.row(2) += curvature * s.t_u.transpose();
  Q_xx(2, 2) += curvature * s.t;
  if constexpr (n == 5) {
    Q_xx.template block<1, 2>(2, 3) += curvature * s.lag.t_a.transpose();
    Q_xx.template block<2, 1>(3, 2) += curvature * s.lag.t_a;
    Q_xx.template bottomRightCorner<2, 2>() += curvature * s.lag.C_aa;
    Q_xu.template bottomRows<2>() += curvature * s.lag.C_au;
  }
}

// Returns false unless M is positive definite by a safe margin.
bool invert(const Matrix2d& M, Matrix2d& inverse) {
  const double product = M(0, 0) * M(1, 1), determinant = product - M(1, 0) * M(1, 0);
  if (!(M(0, 0) > 0.0 && determinant > 1e-12 * product)) return false;
  const double per = 1.0 / determinant;
  inverse << per * M(1, 1), -per * M(1, 0), -per * M(1, 0), per * M(0, 0);
  return true;
}

// One step of (2): takes V from the end of the stage to its start. Returns false if the pivot is
// not positive definite.
template <int n>
bool recede(const ChainStage<n>& s, const Convexity& convexity, Value<n>& V, ChainGain<n>& gain) {
  add(s, convexity, V);
  gain.P_xx = V.xx;
  gain.P_xu = V.xu;
  gain.p_x = V.x;

  const Eigen::Matrix<double, n, 2> T = V.xx * s.B + V.xu;
  Matrix2d Q_uu = s.B.transpose() * T + V.xu.transpose() * s.B + V.uu;
  Q_uu.diagonal() += s.D;
  Matrix2d inverse;
  if (!invert(Q_uu, inverse)) return false;
  Eigen::Matrix<double, n, 2> Q_xu = before(s, T);
  Eigen::Matrix<double, n, n> Q_xx;
  if constexpr (n == 3) {
    Q_xx = before(s, V.xx);
    Q_xx.col(2) += Q_xx.template leftCols<2>() * s.a;
  } else {
    Q_xx = before(s, Eigen::Matrix<double, n, n>{before(s, V.xx).transpose()});
  }
  add_motion(s, convexity.curvature, Q_xx, Q_xu);

  const ChainState<n> x_after = V.x + V.xx * s.c;
  const Vector2d g = s.g + s.D.cwiseProduct(s.e);
  const Vector2d q_u = s.B.transpose() * x_after + V.u + V.xu.transpose() * s.c + g;
  gain.k = -inverse * q_u;
  gain.K = -inverse * Q_xu.transpose();
  gain.L = inverse * s.D.asDiagonal();

  V.xx = Q_xx + Q_xu * gain.K;
  V.xu = Q_xu * gain.L;
  V.uu = -(s.D.asDiagonal() * gain.L);
  V.uu.diagonal() += s.D;
  V.x = before(s, x_after) + Q_xu * gain.k;
  V.u = -g - s.D.cwiseProduct(gain.k);
  return true;
}

}  // namespace

template <int n>
bool factorize(std::span<const ChainStage<n>> stages, const Convexity& convexity,
               std::span<ChainGain<n>> gains) {
  Value<n> V;
  for (std::size_t k = stages.size(); k-- > 0;)
    if (!recede(stages[k], convexity, V, gains[k])) return false;
  return true;
}

template <int n>
void roll_out(std::span<const ChainStage<n>> stages, std::span<const ChainGain<n>> gains,
              std::span<ChainStep<n>> steps) {
  ChainState<n> X = ChainState<n>::Zero();
  Vector2d u = Vector2d::Zero();
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const ChainStage<n>& s = stages[k];
    const ChainGain<n>& gain = gains[k];
    ChainStep<n>& step = steps[k];
    step.u = gain.k + gain.K * X + gain.L * u;
    step.d = step.u - u + s.e;
    step.X = X + s.B * step.u + s.c;
    step.X.template head<2>() += X.z() * s.a;
    if constexpr (n == 5) {
      step.X.template head<3>() += s.lag.M * X.template tail<2>();
      step.X.template tail<2>() -=
          (1.0 - s.lag.E.array()).matrix().cwiseProduct(X.template tail<2>());
    }
    step.pi = gain.P_xx * step.X + gain.P_xu * step.u + gain.p_x;
    step.lambda = s.g + s.D.cwiseProduct(step.d);
    X = step.X;
    u = step.u;
  }
}

template bool factorize<3>(std::span<const ChainStage<3>>, const Convexity&,
                           std::span<ChainGain<3>>);
template bool factorize<5>(std::span<const ChainStage<5>>, const Convexity&,
                           std::span<ChainGain<5>>);
template void roll_out<3>(std::span<const ChainStage<3>>, std::span<const ChainGain<3>>,
                          std::span<ChainStep<3>>);
template void roll_out<5>(std::span<const ChainStage<5>>, std::span<const ChainGain<5>>,
                          std::span<ChainStep<5>>);

}  // namespace tandem
