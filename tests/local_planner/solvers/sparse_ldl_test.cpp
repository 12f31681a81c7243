// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/sparse_ldl.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "local_planner/planning_cases.hpp"
#include "tandem/local_planner/solvers/ipopt_linear_solver.hpp"

namespace tandem::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Triplets {
  int size = 0;
  std::vector<int> rows = {}, columns = {};
  std::vector<double> values = {};

  void add(int row, int column, double value) {
    rows.push_back(row + 1);
    columns.push_back(column + 1);
    values.push_back(value);
  }
  [[nodiscard]] MatrixXd dense() const {
    MatrixXd A = MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < values.size(); ++i) {
      A(rows[i] - 1, columns[i] - 1) += values[i];
      if (rows[i] != columns[i]) A(columns[i] - 1, rows[i] - 1) += values[i];
    }
    return A;
  }
};

// The system of Ipopt's step at a point: unknowns z, slacks, λ of the equalities, λ of rows (4).
Triplets newton_system(const Ocp& ocp, const std::vector<double>& z, double regularization,
                       Random& random) {
  const int n = variables(ocp), m = rows(ocp),
            equalities = static_cast<int>(tandem::equalities(ocp)) * ocp.horizon();
  const int pairs = m - equalities;
  std::vector<double> lambda(static_cast<std::size_t>(m));
  for (double& value : lambda) value = random(-5.0, 5.0);
  Triplets out{.size = n + pairs + m};
  const auto H = hessian_pattern(ocp), J = jacobian_pattern(ocp);
  std::vector<double> h(H.size()), j(J.size());
  hessian_values(ocp, z, 1.0, lambda, h);
  jacobian_values(ocp, z, j);
  for (std::size_t i = 0; i < H.size(); ++i) out.add(H[i].row, H[i].column, h[i]);
  for (int i = 0; i < n; ++i) out.add(i, i, regularization + random(0.0, 0.1));
  for (int i = 0; i < pairs; ++i) out.add(n + i, n + i, random(1e-3, 1e3));
  for (std::size_t i = 0; i < J.size(); ++i) {
    out.add(n + pairs + J[i].row, J[i].column, j[i]);
  }
  for (int i = 0; i < pairs; ++i) out.add(n + pairs + equalities + i, n + i, -1.0);
  for (int i = 0; i < m; ++i) out.add(n + pairs + i, n + pairs + i, 0.0);
  return out;
}

int negative_eigenvalues(const MatrixXd& A) {
  const VectorXd all =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
  return static_cast<int>((all.array() < 0.0).count());
}

TEST(SparseLdl, SolvesTheSystemsOfIpoptsStepsAndCountsTheirNegativeEigenvalues) {
  Random random{std::mt19937(5)};
  int right = 0, wrong = 0;
  for (unsigned seed = 0; seed < 50; ++seed) {
    PlanningCase c = random_case(seed);
    c.params.horizon_steps = 6;
    const StartingPoint start = first_problem(c, true);
    SparseLdl ldl;
    for (const double regularization : {0.0, 1.0, 100.0}) {
      const Triplets system = newton_system(start.ocp, start.guess.z, regularization, random);
      const MatrixXd A = system.dense();
      ldl.analyse(system.size, system.rows, system.columns, stage_pivots(start.ocp));
      ASSERT_TRUE(ldl.factorize(system.values));
      EXPECT_EQ(ldl.negative(), negative_eigenvalues(A)) << seed;
      ++(ldl.negative() == rows(start.ocp) ? right : wrong);
      const VectorXd b = VectorXd::NullaryExpr(system.size, [&] { return random(-1.0, 1.0); });
      VectorXd x = b;
      ldl.solve({x.data(), static_cast<std::size_t>(x.size())});
      EXPECT_LT((A * x - b).lpNorm<Eigen::Infinity>(), 1e-8 * (1.0 + x.lpNorm<Eigen::Infinity>()));
    }
  }
  EXPECT_GT(right, 10);  // both kinds were seen
  EXPECT_GT(wrong, 10);
}

TEST(SparseLdl, RefusesWhatItsPivotsCannotFactor) {
  SparseLdl ldl;
  const std::vector<int> rows{1, 2, 2}, columns{1, 1, 2};
  ldl.analyse(2, rows, columns, std::vector<Pivot>{{0}, {1}});
  EXPECT_FALSE(ldl.factorize(std::vector<double>{0.0, 1.0, 0.0}));
  EXPECT_FALSE(ldl.factorize(std::vector<double>{1.0, 1.0, 1.0}));
  EXPECT_TRUE(ldl.factorize(std::vector<double>{1.0, 1.0, 0.0}));
  EXPECT_EQ(ldl.negative(), 1);
  SparseLdl together;
  together.analyse(2, rows, columns, std::vector<Pivot>{{0, 1}});
  EXPECT_TRUE(together.factorize(std::vector<double>{0.0, 1.0, 0.0}));
  EXPECT_EQ(together.negative(), 1);
  EXPECT_FALSE(together.factorize(std::vector<double>{1.0, 1.0, 1.0}));
  EXPECT_FALSE(together.factorize(std::vector<double>{1.0, std::nan(""), 1.0}));
}

}  // namespace
}  // namespace tandem::test
