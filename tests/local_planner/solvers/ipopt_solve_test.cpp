// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/ipopt_solve.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <cstdio>
#include <thread>

#include "local_planner/planning_cases.hpp"
#include "support/instrumented.hpp"
#include "tandem/local_planner/solvers/ipopt_options.hpp"
#include "tandem/local_planner/solvers/optimality.hpp"
#include "tandem/local_planner/solvers/riccati_solver.hpp"

namespace tandem::test {
namespace {

// The four begins of a case. Warm ones follow from a cold solution.
std::vector<StartingPoint> begins(unsigned seed) {
  const PlanningCase c = random_case(seed);
  RiccatiSolver solver;
  std::vector<StartingPoint> all{first_problem(c, false), first_problem(c, true)};
  const Iterate end = solver.solve(all[0].ocp, all[0].guess, {.iterations = 300}).point;
  const Solved last{all[0].ocp, end, 0.0};
  all.push_back(next_problem(c, last, false, seed));
  all.push_back(next_problem(c, last, true, seed));
  return all;
}

class IpoptSolve : public testing::Test {
 protected:
  void SetUp() override {
    if (best_linear_solver() != LinearSolver::kStages)
      GTEST_SKIP() << "this Ipopt takes no linear solver";
  }
};

// Pivoting changes nothing: iteration by iteration the two go the same way.
TEST_F(IpoptSolve, BothLinearSolversTakeTheSameIterations) {
  int same = 0, all = 0;
  for (unsigned seed = 30000; seed < 30000 + samples(40, 5); ++seed)
    for (const StartingPoint& start : begins(seed)) {
      const SolveLimits limits{.iterations = 40};
      const Solution ours = ipopt_solve(start.ocp, start.guess, limits, LinearSolver::kStages);
      const Solution mumps = ipopt_solve(start.ocp, start.guess, limits, LinearSolver::kMumps);
      const double a = cost(start.ocp, ours.point.z), b = cost(start.ocp, mumps.point.z);
      const bool is_same = ours.status == mumps.status && ours.iterations == mumps.iterations &&
                           std::abs(a - b) < 1e-6 * (1.0 + std::abs(b));
      if (!is_same)
        std::printf("seed %u: %d and %d iterations, cost %g and %g\n", seed, ours.iterations,
                    mumps.iterations, a, b);
      same += is_same ? 1 : 0;
      ++all;
    }
  EXPECT_LE(all - same, std::max(1.0, 0.03 * all));  // rounding may turn a line search
}

// One case in four begins inside of obstacles, blind guesses go through all of them.
TEST_F(IpoptSolve, ConvergesFromAnywhereInFewIterations) {
  std::vector<int> iterations;
  int converged = 0;
  for (unsigned seed = 31000; seed < 31000 + samples(150, 20); ++seed)
    for (const StartingPoint& start : begins(seed)) {
      const Solution end = ipopt_solve(start.ocp, start.guess, {.iterations = 150});
      iterations.push_back(end.iterations);
      converged += end.status == SolveStatus::kConverged ? 1 : 0;
      if (end.status != SolveStatus::kConverged)
        std::printf("seed %u: %d iterations\n", seed, end.iterations);
      else
        EXPECT_TRUE(is_optimal(optimality_error(start.ocp, end.point))) << seed;
    }
  std::sort(iterations.begin(), iterations.end());
  std::printf("iterations p50 %d p99 %d max %d\n", iterations[iterations.size() / 2],
              iterations[iterations.size() * 99 / 100], iterations.back());
  if (kInstrumented) return;  // too few samples for percentiles: their 99th is the worst of 80
  EXPECT_LE(iterations[iterations.size() * 99 / 100], 80);
  // Rounding may send a start round in circles: seen once in 600.
  EXPECT_GE(converged, static_cast<double>(iterations.size()) * 0.995);
}

// More structures than a thread keeps, each twice: what was set up for an earlier problem, or for
// another one, leaves no trace.
TEST_F(IpoptSolve, EqualCallsGiveEqualResultsBitForBit) {
  std::vector<StartingPoint> starts;
  for (unsigned seed = 32000; seed < 32006; ++seed)
    for (StartingPoint& start : begins(seed)) starts.push_back(std::move(start));
  std::vector<Solution> first;
  for (const StartingPoint& start : starts)
    std::thread([&] { first.push_back(ipopt_solve(start.ocp, start.guess, {})); }).join();
  for (std::size_t i = 0; i < starts.size(); ++i)
    for (int repeat = 0; repeat < 3; ++repeat) {
      const Solution again = ipopt_solve(starts[i].ocp, starts[i].guess, {});
      EXPECT_EQ(again.iterations, first[i].iterations) << i << ' ' << repeat;
      EXPECT_EQ(again.point.z, first[i].point.z) << i << ' ' << repeat;
      EXPECT_EQ(again.point.lambda, first[i].point.lambda) << i << ' ' << repeat;
    }
}

class LinearSolvers : public testing::TestWithParam<LinearSolver> {};
INSTANTIATE_TEST_SUITE_P(All, LinearSolvers,
                         testing::Values(LinearSolver::kMumps, best_linear_solver()));

TEST_P(LinearSolvers, ThreadsSolveAtTheSameTime) {
  const std::vector<StartingPoint> starts = begins(33000);
  std::vector<Solution> expected;
  for (const StartingPoint& start : starts)
    expected.push_back(ipopt_solve(start.ocp, start.guess, {}, GetParam()));
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (int& count : wrong)
    threads.emplace_back([&] {
      for (int repeat = 0; repeat < 5; ++repeat)
        for (std::size_t i = 0; i < starts.size(); ++i) {
          const Solution now = ipopt_solve(starts[i].ocp, starts[i].guess, {}, GetParam());
          count += now.point.z == expected[i].point.z ? 0 : 1;
        }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST_P(LinearSolvers, StopAtTheirLimits) {
  const StartingPoint start = first_problem(random_case(1), true);
  const Solution three = ipopt_solve(start.ocp, start.guess, {.iterations = 3}, GetParam());
  EXPECT_EQ(three.status, SolveStatus::kTimeout);
  EXPECT_EQ(three.iterations, 3);
  const SolveLimits late{.deadline = std::chrono::steady_clock::now()};
  EXPECT_EQ(ipopt_solve(start.ocp, start.guess, late, GetParam()).status, SolveStatus::kTimeout);
  EXPECT_EQ(ipopt_solve(start.ocp, start.guess, {}, GetParam()).status, SolveStatus::kConverged);
}

TEST_F(IpoptSolve, KeepsAVariableWhoseBoundsMeet) {
  StartingPoint start = first_problem(random_case(2), false);
  for (Interval& range : start.ocp.w) range = {0.0, 0.0};
  start.ocp.command.w = 0.0;
  const Solution end = ipopt_solve(start.ocp, start.guess, {});
  EXPECT_EQ(end.status, SolveStatus::kConverged);
  for (int k = 0; k < start.ocp.horizon(); ++k)
    EXPECT_EQ(at(start.ocp, end.point.z, static_cast<std::size_t>(k), kW), 0.0);
}

TEST(RememberedOptions, AnOptionSetAgainIsSeenAgain) {
  RememberedOptions options;
  for (const double value : {1.0, 2.0}) {
    options.SetNumericValue("tol", value);
    double seen = 0.0;
    EXPECT_TRUE(options.GetNumericValue("tol", seen, ""));
    EXPECT_TRUE(options.GetNumericValue("tol", seen, ""));
    EXPECT_EQ(seen, value);
  }
  options.SetNumericValue("resto.tol", 3.0);
  double seen = 0.0;
  EXPECT_TRUE(options.GetNumericValue("tol", seen, "resto."));
  EXPECT_EQ(seen, 3.0);
  EXPECT_FALSE(options.GetNumericValue("mu_init", seen, ""));
}

}  // namespace
}  // namespace tandem::test
