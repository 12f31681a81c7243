// SPDX-License-Identifier: Apache-2.0
#include "local_planner/riccati.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <random>
#include <vector>

namespace tandem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kStages = 6;

struct Numbers {
  std::mt19937 random{11};
  double operator()() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); }
  template <class Matrix>
  Matrix matrix() {
    return Matrix::NullaryExpr([this] { return (*this)(); });
  }
};

// `concave`: how much of the curvature may be negative.
std::vector<ChainStage> random_chain(Numbers& number, double concave) {
  std::vector<ChainStage> stages(kStages);
  for (ChainStage& s : stages) {
    const MatrixXd root = number.matrix<Eigen::Matrix<double, 5, 5>>();
    const MatrixXd H = root * root.transpose();
    s.H_xx = H.topLeftCorner<3, 3>();
    s.H_xu = H.topRightCorner<3, 2>();
    s.H_uu = H.bottomRightCorner<2, 2>();
    const auto C = number.matrix<Eigen::Matrix3d>();
    s.C_xx = -concave * (C * C.transpose());
    const double vw = concave * number();
    s.C_uu << 0.0, vw, vw, concave * number();
    s.h_x = number.matrix<Eigen::Vector3d>();
    s.h_u = number.matrix<Eigen::Vector2d>();
    s.t = concave * number();
    s.t_u = concave * number.matrix<Eigen::Vector2d>();
    s.D = number.matrix<Eigen::Vector2d>().cwiseAbs();
    s.g = number.matrix<Eigen::Vector2d>();
    s.e = number.matrix<Eigen::Vector2d>();
    s.a = number.matrix<Eigen::Vector2d>();
    s.B = number.matrix<Eigen::Matrix<double, 3, 2>>();
    s.c = number.matrix<Eigen::Vector3d>();
  }
  return stages;
}

// The same problem, dense: ½ zᵀHz + hᵀz with E z = b, where z_k = (u, d, X⁺).
struct Dense {
  MatrixXd H = MatrixXd::Zero(7 * kStages, 7 * kStages);
  VectorXd h = VectorXd::Zero(7 * kStages);
  MatrixXd E = MatrixXd::Zero(5 * kStages, 7 * kStages);
  VectorXd b = VectorXd::Zero(5 * kStages);
};

Dense dense(const std::vector<ChainStage>& stages) {
  Dense out;
  for (int k = 0; k < kStages; ++k) {
    const ChainStage& s = stages[static_cast<std::size_t>(k)];
    const int u = 7 * k, d = u + 2, X = u + 4, row = 5 * k;
    out.H.block<3, 3>(X, X) += s.H_xx + s.C_xx;
    out.H.block<3, 2>(X, u) += s.H_xu;
    out.H.block<2, 3>(u, X) += s.H_xu.transpose();
    out.H.block<2, 2>(u, u) += s.H_uu + s.C_uu;
    out.H.block<2, 2>(d, d).diagonal() += s.D;
    out.h.segment<3>(X) = s.h_x;
    out.h.segment<2>(u) = s.h_u;
    out.h.segment<2>(d) = s.g;
    out.E.block<2, 2>(row, u).setIdentity();  // Δu − Δu' − Δd = −e
    out.E.block<2, 2>(row, d) = -Eigen::Matrix2d::Identity();
    out.b.segment<2>(row) = -s.e;
    out.E.block<3, 3>(row + 2, X).setIdentity();  // ΔX⁺ − A ΔX − B Δu = c
    out.E.block<3, 2>(row + 2, u) = -s.B;
    out.b.segment<3>(row + 2) = s.c;
    if (k == 0) continue;
    const int theta = u - 1;
    out.E.block<2, 2>(row, u - 7) = -Eigen::Matrix2d::Identity();
    out.E.block<3, 3>(row + 2, X - 7) = -Eigen::Matrix3d::Identity();
    out.E.block<2, 1>(row + 2, theta) = -s.a;
    out.H(theta, theta) += s.t;
    out.H.block<1, 2>(theta, u) += s.t_u.transpose();
    out.H.block<2, 1>(u, theta) += s.t_u;
  }
  return out;
}

TEST(Riccati, StepAndMultipliersSolveTheDenseSystem) {
  Numbers number;
  for (int i = 0; i < 50; ++i) {
    const auto stages = random_chain(number, 0.01);
    std::vector<ChainGain> gains(kStages);
    std::vector<ChainStep> steps(kStages);
    ASSERT_TRUE(factorize(stages, {.delta = 0.1}, gains));
    roll_out(stages, gains, steps);

    Dense problem = dense(stages);
    for (int k = 0; k < kStages; ++k)
      for (const int place : {0, 1, 4, 5, 6}) problem.H(7 * k + place, 7 * k + place) += 0.1;
    const int n = 7 * kStages, m = 5 * kStages;
    MatrixXd K = MatrixXd::Zero(n + m, n + m);
    K.topLeftCorner(n, n) = problem.H;
    K.topRightCorner(n, m) = problem.E.transpose();
    K.bottomLeftCorner(m, n) = problem.E;
    VectorXd right(n + m);
    right << -problem.h, problem.b;
    const VectorXd exact = K.fullPivLu().solve(right);
    for (int k = 0; k < kStages; ++k) {
      const ChainStep& step = steps[static_cast<std::size_t>(k)];
      EXPECT_LT((step.u - exact.segment<2>(7 * k)).norm(), 1e-8);
      EXPECT_LT((step.d - exact.segment<2>(7 * k + 2)).norm(), 1e-8);
      EXPECT_LT((step.X - exact.segment<3>(7 * k + 4)).norm(), 1e-8);
      EXPECT_LT((step.lambda - exact.segment<2>(n + 5 * k)).norm(), 1e-7);
      EXPECT_LT((step.pi + exact.segment<3>(n + 5 * k + 2)).norm(), 1e-7);
    }
  }
}

TEST(Riccati, RefusesExactlyWhatIsNotConvexOnTheConstraints) {
  Numbers number;
  int convex = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    const auto stages = random_chain(number, 0.3);
    const Dense problem = dense(stages);
    const MatrixXd kernel = problem.E.fullPivLu().kernel();
    const MatrixXd reduced = kernel.transpose() * problem.H * kernel;
    const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(reduced).eigenvalues()[0];
    if (std::abs(least) < 1e-9) continue;
    std::vector<ChainGain> gains(kStages);
    const bool accepted = factorize(stages, {}, gains);
    EXPECT_EQ(accepted, least > 0.0) << least;
    ++(least > 0.0 ? convex : refused);
  }
  EXPECT_GT(convex, 20);
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace tandem
