// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/ocp/ocp.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <set>

#include "tandem/local_planner/solvers/ipopt_solve.hpp"

namespace tandem {
namespace {

struct Numbers {
  std::mt19937 random{7};
  double operator()(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(random);
  }
};

Ocp random_problem(Numbers& number, bool arc, bool lags = false) {
  Ocp ocp{.dt = 0.25,
          .half = arc ? 0.125 : 0.0,
          .gap_v = 0.12,
          .gap_w = 0.03,
          .X_MB = {0.3, -0.2, 3.0},
          .command = {0.2, -0.1}};
  if (lags) {
    ocp.lag = LagStep::over(ocp.dt, {number(0.0, 1.0), number(0.05, 1.0)});
    ocp.motion = {number(-1, 1), number(-1, 1)};
  }
  for (int k = 0; k < 5; ++k) {
    ocp.v.push_back({-0.4, 0.8});
    ocp.w.push_back({-1.0, 1.0});
    ocp.change_v.push_back({-0.1, 0.1});
    ocp.change_w.push_back({-0.1, 0.1});
    Stage stage;
    stage.cost = {.X_MR = {number(-2, 2), number(-2, 2), number(-4, 4)},
                  .twist = {number(-1, 1), number(-1, 1)},
                  .change = {number(-1, 1), number(-1, 1)},
                  .q_x = 6,
                  .q_y = 5,
                  .q_xy = number(-2, 2),
                  .q_theta = 4,
                  .r_v = 0.3,
                  .r_w = 0.15,
                  .c_v = 0.2,
                  .c_w = 0.1,
                  .c_dir = k % 2 == 0 ? 0.65 : 0.0,
                  .direction = number(-3, 3)};
    for (int i = 0; i < k % 3; ++i)
      stage.pairs.push_back(
          {{number(-0.4, 0.4), number(-0.2, 0.2)},
           0.4,
           {1, {number(-2, 2), number(-2, 2)}, number(0.3, 2.0), 0.2, number(-2, 2), {0, 0}},
           0});
    ocp.stages.push_back(stage);
  }
  return ocp;
}

std::vector<double> random_point(const Ocp& ocp, Numbers& number) {
  std::vector<double> z(static_cast<std::size_t>(variables(ocp)));
  for (double& value : z) value = number(-3, 3);
  return z;
}

std::vector<double> gradient_at(const Ocp& ocp, const std::vector<double>& z) {
  std::vector<double> gradient(z.size());
  cost_gradient(ocp, z, gradient);
  return gradient;
}

std::vector<double> rows_at(const Ocp& ocp, const std::vector<double>& z) {
  std::vector<double> values(static_cast<std::size_t>(rows(ocp)));
  row_values(ocp, z, values);
  return values;
}

Eigen::MatrixXd jacobian_at(const Ocp& ocp, const std::vector<double>& z) {
  const auto pattern = jacobian_pattern(ocp);
  std::vector<double> values(pattern.size(), std::nan(""));
  jacobian_values(ocp, z, values);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows(ocp), variables(ocp));
  for (std::size_t i = 0; i < pattern.size(); ++i)
    J(pattern[i].row, pattern[i].column) += values[i];
  return J;
}

constexpr double h = 1e-6;

// Runs `compare(ocp, z)` for both models, with and without a lag, at random points.
template <class Compare>
void at_random_points(Compare&& compare) {
  Numbers number;
  for (int i = 0; i < 40; ++i) {
    const Ocp ocp = random_problem(number, i % 2 == 0, i % 4 < 2);
    compare(ocp, random_point(ocp, number), number);
  }
}

TEST(Ocp, GradientMatchesFiniteDifferences) {
  at_random_points([](const Ocp& ocp, std::vector<double> z, Numbers&) {
    const auto gradient = gradient_at(ocp, z);
    for (std::size_t i = 0; i < z.size(); ++i) {
      const double at = z[i];
      z[i] = at + h;
      const double plus = cost(ocp, z);
      z[i] = at - h;
      const double minus = cost(ocp, z);
      z[i] = at;
      EXPECT_NEAR(gradient[i], (plus - minus) / (2 * h), 1e-4) << "variable " << i;
    }
  });
}

TEST(Ocp, JacobianMatchesFiniteDifferencesAndItsPatternIsComplete) {
  at_random_points([](const Ocp& ocp, std::vector<double> z, Numbers&) {
    const Eigen::MatrixXd J = jacobian_at(ocp, z);
    for (std::size_t i = 0; i < z.size(); ++i) {
      const double at = z[i];
      z[i] = at + h;
      const auto plus = rows_at(ocp, z);
      z[i] = at - h;
      const auto minus = rows_at(ocp, z);
      z[i] = at;
      for (std::size_t r = 0; r < plus.size(); ++r)
        EXPECT_NEAR(J(static_cast<int>(r), static_cast<int>(i)), (plus[r] - minus[r]) / (2 * h),
                    1e-6)
            << "row " << r << " variable " << i;
    }
  });
}

TEST(Ocp, HessianOfTheLagrangianMatchesFiniteDifferencesOfTheGradient) {
  at_random_points([](const Ocp& ocp, std::vector<double> z, Numbers& number) {
    const double sigma = number(0.1, 2.0);
    Eigen::VectorXd lambda(rows(ocp));
    for (double& value : lambda) value = number(-2, 2);

    const auto pattern = hessian_pattern(ocp);
    std::vector<double> values(pattern.size(), std::nan(""));
    hessian_values(ocp, z, sigma, {lambda.data(), static_cast<std::size_t>(lambda.size())}, values);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(variables(ocp), variables(ocp));
    for (std::size_t i = 0; i < pattern.size(); ++i) {
      ASSERT_GE(pattern[i].row, pattern[i].column);
      H(pattern[i].row, pattern[i].column) += values[i];
      if (pattern[i].row != pattern[i].column) H(pattern[i].column, pattern[i].row) += values[i];
    }

    const auto lagrangian_gradient = [&](const std::vector<double>& at) -> Eigen::VectorXd {
      const auto g = gradient_at(ocp, at);
      return sigma * Eigen::Map<const Eigen::VectorXd>(g.data(), variables(ocp)) +
             jacobian_at(ocp, at).transpose() * lambda;
    };
    for (std::size_t i = 0; i < z.size(); ++i) {
      std::vector<double> plus = z, minus = z;
      plus[i] += h;
      minus[i] -= h;
      const Eigen::VectorXd column =
          (lagrangian_gradient(plus) - lagrangian_gradient(minus)) / (2 * h);
      for (int r = 0; r < variables(ocp); ++r) {
        const double exact = H(r, static_cast<int>(i));
        EXPECT_NEAR(exact, column[r], 2e-4 * std::max(1.0, std::abs(exact)))
            << "entry " << r << ", " << i;
      }
    }
  });
}

TEST(Ocp, PatternDependsOnSizesOnlyAndNamesNoEntryTwice) {
  Numbers number;
  for (const bool lags : {false, true}) {
    const Ocp ocp = random_problem(number, true, lags);
    for (const auto& pattern : {jacobian_pattern(ocp), hessian_pattern(ocp)}) {
      std::set<std::pair<int, int>> entries;
      for (const Entry& entry : pattern) entries.insert({entry.row, entry.column});
      EXPECT_EQ(entries.size(), pattern.size());
    }
  }
}

TEST(Ocp, ArcModelIsTheExactArcAndEulerTheThesissStep) {
  const Pose2 X{0.3, -0.2, 3.0};
  const Twist2 u{0.7, -0.9};
  const Pose2 arc = advance({.dt = 0.25, .half = 0.125}, X, u), exact = integrate(X, u, 0.25);
  EXPECT_NEAR(arc.x, exact.x, 1e-12);
  EXPECT_NEAR(arc.y, exact.y, 1e-12);
  const Pose2 euler = advance({.dt = 0.25, .half = 0.0}, X, u);
  EXPECT_NEAR(euler.x, X.x + 0.25 * u.v * std::cos(X.theta), 1e-12);  // [T] 3.10
  EXPECT_NEAR(euler.y, X.y + 0.25 * u.v * std::sin(X.theta), 1e-12);
  EXPECT_NEAR(euler.theta, X.theta + 0.25 * u.w, 1e-12);
}

// Against small steps of the differential equation: of the twist exactly, of the pose as far as the
// arc of the mean twist is the arc that is driven.
TEST(Ocp, LaggingRobotMovesByTheMeanOfWhatItDoes) {
  const MotorLag lag{0.4, 0.25};
  const Ocp ocp{.dt = 0.25, .half = 0.125, .lag = LagStep::over(0.25, lag)};
  const Moving from{{0.3, -0.2, 3.0}, {0.6, -0.4}};
  const Twist2 u{0.1, 0.8};
  const Moving end = advance(ocp, from, u), same = follow(from, u, lag, 0.25);
  EXPECT_NEAR(end.X_MB.x, same.X_MB.x, 1e-12);
  EXPECT_NEAR(end.X_MB.theta, same.X_MB.theta, 1e-12);
  Moving fine = from;
  constexpr int kSteps = 2500;
  for (int i = 0; i < kSteps; ++i) {
    const double step = 0.25 / kSteps;
    fine.X_MB = integrate(fine.X_MB, fine.twist, step);
    fine.twist.v += step / lag.v * (u.v - fine.twist.v);
    fine.twist.w += step / lag.w * (u.w - fine.twist.w);
  }
  EXPECT_NEAR(end.twist.v, fine.twist.v, 1e-4);
  EXPECT_NEAR(end.twist.w, fine.twist.w, 1e-4);
  EXPECT_NEAR(end.X_MB.theta, fine.X_MB.theta, 1e-4);
  EXPECT_NEAR((end.X_MB.position() - fine.X_MB.position()).norm(), 0.0, 3e-3);
}

// Full turns of the target's heading change nothing.
TEST(Ocp, HeadingErrorDoesNotJumpAtPi) {
  Numbers number;
  Ocp ocp = random_problem(number, true);
  const auto z = random_point(ocp, number);
  const double before = cost(ocp, z);
  for (Stage& stage : ocp.stages) stage.cost.X_MR.theta += 2.0 * std::numbers::pi;
  EXPECT_NEAR(cost(ocp, z), before, 1e-9);
}

}  // namespace
}  // namespace tandem
