// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/riccati.hpp"

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

// `concave`: how much of the curvature may be negative. n: states that a stage hands on.
template <int n>
std::vector<ChainStage<n>> random_chain(Numbers& number, double concave) {
  std::vector<ChainStage<n>> stages(kStages);
  for (ChainStage<n>& s : stages) {
    const MatrixXd root = number.matrix<Eigen::Matrix<double, 5, 5>>();
    const MatrixXd H = root * root.transpose();
    s.H_xx.setZero();
    s.H_xx.template topLeftCorner<3, 3>() = H.topLeftCorner<3, 3>();
    s.H_xu = H.topRightCorner<3, 2>();
    s.H_uu = H.bottomRightCorner<2, 2>();
    const auto C = number.matrix<Eigen::Matrix3d>();
    s.C_xx = -concave * (C * C.transpose());
    const double vw = concave * number();
    s.C_uu << 0.0, vw, vw, concave * number();
    s.h_x = number.matrix<ChainState<n>>();
    s.h_u = number.matrix<Eigen::Vector2d>();
    s.t = concave * number();
    s.t_u = concave * number.matrix<Eigen::Vector2d>();
    s.D = number.matrix<Eigen::Vector2d>().cwiseAbs();
    s.g = number.matrix<Eigen::Vector2d>();
    s.e = number.matrix<Eigen::Vector2d>();
    s.a = number.matrix<Eigen::Vector2d>();
    s.B = number.matrix<Eigen::Matrix<double, n, 2>>();
    s.c = number.matrix<ChainState<n>>();
    if constexpr (n == 5) {
      const auto more = number.matrix<Eigen::Matrix<double, 5, 5>>();
      s.H_xx += more * more.transpose();
      s.lag.E = number.matrix<Eigen::Vector2d>().cwiseAbs();
      s.lag.M = number.matrix<Eigen::Matrix<double, 3, 2>>();
      s.lag.t_a = concave * number.matrix<Eigen::Vector2d>();
      const auto aa = number.matrix<Eigen::Matrix2d>();
      s.lag.C_aa = concave * (aa + aa.transpose());
      s.lag.C_au = concave * number.matrix<Eigen::Matrix2d>();
    }
  }
  return stages;
}

// The same problem, dense: ½ zᵀHz + hᵀz with E z = b, where z_k = (u, d, X⁺).
template <int n>
struct Dense {
  static constexpr int kBlock = n + 4, kRows = n + 2;
  MatrixXd H = MatrixXd::Zero(kBlock * kStages, kBlock* kStages);
  VectorXd h = VectorXd::Zero(kBlock * kStages);
  MatrixXd E = MatrixXd::Zero(kRows * kStages, kBlock* kStages);
  VectorXd b = VectorXd::Zero(kRows * kStages);
};

template <int n>
Dense<n> dense(const std::vector<ChainStage<n>>& stages) {
  constexpr int kBlock = Dense<n>::kBlock;
  Dense<n> out;
  for (int k = 0; k < kStages; ++k) {
    const ChainStage<n>& s = stages[static_cast<std::size_t>(k)];
    const int u = kBlock * k, d = u + 2, X = u + 4, row = (n + 2) * k;
    out.H.template block<n, n>(X, X) += s.H_xx;
    out.H.template block<3, 3>(X, X) += s.C_xx;
    out.H.template block<3, 2>(X, u) += s.H_xu;
    out.H.template block<2, 3>(u, X) += s.H_xu.transpose();
    out.H.template block<2, 2>(u, u) += s.H_uu + s.C_uu;
    out.H.template block<2, 2>(d, d).diagonal() += s.D;
    out.h.template segment<n>(X) = s.h_x;
    out.h.template segment<2>(u) = s.h_u;
    out.h.template segment<2>(d) = s.g;
    out.E.template block<2, 2>(row, u).setIdentity();  // Δu − Δu' − Δd = −e
    out.E.template block<2, 2>(row, d) = -Eigen::Matrix2d::Identity();
    out.b.template segment<2>(row) = -s.e;
    out.E.template block<n, n>(row + 2, X).setIdentity();  // ΔX⁺ − A ΔX − B Δu = c
    out.E.template block<n, 2>(row + 2, u) = -s.B;
    out.b.template segment<n>(row + 2) = s.c;
    if (k == 0) continue;
    const int before = X - kBlock, theta = before + 2, twist = before + 3;
    out.E.template block<2, 2>(row, u - kBlock) = -Eigen::Matrix2d::Identity();
    out.E.template block<3, 3>(row + 2, before) = -Eigen::Matrix3d::Identity();
    out.E.template block<2, 1>(row + 2, theta) = -s.a;
    out.H(theta, theta) += s.t;
    out.H.template block<1, 2>(theta, u) += s.t_u.transpose();
    out.H.template block<2, 1>(u, theta) += s.t_u;
    if constexpr (n == 5) {
      out.E.template block<3, 2>(row + 2, twist) = -s.lag.M;
      out.E.template block<2, 2>(row + 5, twist) = -Eigen::Matrix2d{s.lag.E.asDiagonal()};
      out.H.template block<1, 2>(theta, twist) += s.lag.t_a.transpose();
      out.H.template block<2, 1>(twist, theta) += s.lag.t_a;
      out.H.template block<2, 2>(twist, twist) += s.lag.C_aa;
      out.H.template block<2, 2>(twist, u) += s.lag.C_au;
      out.H.template block<2, 2>(u, twist) += s.lag.C_au.transpose();
    }
  }
  return out;
}

// n = 3: the pose; 5: the pose and a twist that lags.
template <class N>
class Riccati : public ::testing::Test {};
using Sizes = ::testing::Types<std::integral_constant<int, 3>, std::integral_constant<int, 5>>;
TYPED_TEST_SUITE(Riccati, Sizes);

TYPED_TEST(Riccati, StepAndMultipliersSolveTheDenseSystem) {
  constexpr int n = TypeParam::value, kBlock = Dense<n>::kBlock, kRows = Dense<n>::kRows;
  Numbers number;
  for (int i = 0; i < 50; ++i) {
    const auto stages = random_chain<n>(number, 0.01);
    std::vector<ChainGain<n>> gains(kStages);
    std::vector<ChainStep<n>> steps(kStages);
    ASSERT_TRUE(factorize<n>(stages, {.delta = 0.1}, gains));
    roll_out<n>(stages, gains, steps);

    Dense<n> problem = dense(stages);
    for (int k = 0; k < kStages; ++k)
      for (int place = 0; place < kBlock; ++place)
        if (place != 2 && place != 3) problem.H(kBlock * k + place, kBlock * k + place) += 0.1;
    const int z = kBlock * kStages, m = kRows * kStages;
    MatrixXd K = MatrixXd::Zero(z + m, z + m);
    K.topLeftCorner(z, z) = problem.H;
    K.topRightCorner(z, m) = problem.E.transpose();
    K.bottomLeftCorner(m, z) = problem.E;
    VectorXd right(z + m);
    right << -problem.h, problem.b;
    const VectorXd exact = K.fullPivLu().solve(right);
    for (int k = 0; k < kStages; ++k) {
      const ChainStep<n>& step = steps[static_cast<std::size_t>(k)];
      const VectorXd stage = exact.segment(kBlock * k, kBlock);
      const VectorXd lambda = exact.segment(z + kRows * k, kRows);
      EXPECT_LT((step.u - stage.head<2>()).norm(), 1e-8);
      EXPECT_LT((step.d - stage.segment<2>(2)).norm(), 1e-8);
      EXPECT_LT((step.X - stage.tail<n>()).norm(), 1e-8);
      EXPECT_LT((step.lambda - lambda.head<2>()).norm(), 1e-7);
      EXPECT_LT((step.pi + lambda.tail<n>()).norm(), 1e-7);
    }
  }
}

TYPED_TEST(Riccati, RefusesExactlyWhatIsNotConvexOnTheConstraints) {
  constexpr int n = TypeParam::value;
  Numbers number;
  int convex = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    const auto stages = random_chain<n>(number, n == 3 ? 0.3 : 1.0);
    const Dense<n> problem = dense(stages);
    const MatrixXd kernel = problem.E.fullPivLu().kernel();
    const MatrixXd reduced = kernel.transpose() * problem.H * kernel;
    const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(reduced).eigenvalues()[0];
    if (std::abs(least) < 1e-9) continue;
    std::vector<ChainGain<n>> gains(kStages);
    const bool accepted = factorize<n>(stages, {}, gains);
    EXPECT_EQ(accepted, least > 0.0) << least;
    ++(least > 0.0 ? convex : refused);
  }
  EXPECT_GT(convex, 20);
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace tandem
