// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/solver.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <stdexcept>

#include "local_planner/planning_cases.hpp"
#include "local_planner/requests.hpp"

namespace tandem::test {
namespace {

TEST(Solver, EachKindIsKnownByItsName) {
  for (const auto kind : {SolverKind::kIpopt, SolverKind::kStructured, SolverKind::kCertified})
    EXPECT_EQ(solver_named(name(kind)), kind);
  EXPECT_THROW((void)solver_named("simplex"), std::invalid_argument);
}

TEST(Solver, IpoptConfirmsTheStructuredSolversOptimaWithHardlyAnIteration) {
  Solver certified{SolverKind::kCertified};
  RiccatiSolver structured;
  int confirmed = 0, all = 0;
  for (unsigned seed = 20000; seed < 20300; ++seed)
    for (const bool blind : {false, true}) {
      const StartingPoint start = first_problem(random_case(seed), blind);
      const Answer answer = certified.solve(start.ocp, start.guess, {.iterations = 60});
      ++all;
      if (answer.verdict != Verdict::kConfirmed) continue;
      ++confirmed;
      const Solution& alone = structured.solve(start.ocp, start.guess, {.iterations = 300});
      EXPECT_EQ(answer.by, SolverKind::kStructured);
      EXPECT_EQ(answer.solution.point.z, alone.point.z);
      EXPECT_LE(answer.solution.iterations, alone.iterations + 1) << seed;
    }
  std::printf("%d of %d confirmed\n", confirmed, all);
  EXPECT_GE(confirmed, all * 0.995);
}

// A limit that the structured solver cannot keep: Ipopt takes over, and that is told.
TEST(Solver, IpoptTakesOverWhereTheStructuredSolverDoesNotConverge) {
  const StartingPoint start = first_problem(random_case(1), true);
  Iterate broken = start.guess;
  broken.lower.assign(broken.z.size(), std::numeric_limits<double>::quiet_NaN());
  broken.upper = broken.lower;
  broken.lambda.assign(static_cast<std::size_t>(rows(start.ocp)),
                       std::numeric_limits<double>::quiet_NaN());
  Solver certified{SolverKind::kCertified};
  const Answer answer = certified.solve(start.ocp, broken, {.iterations = 60});
  EXPECT_EQ(answer.verdict, Verdict::kDisagreement);
  EXPECT_EQ(certified.solve(start.ocp, start.guess, {.iterations = 60}).verdict,
            Verdict::kConfirmed);
}

TEST(Solver, AnAnswerInTimeIsNotHeldBackByALateConfirmation) {
  const StartingPoint start = first_problem(random_case(1), false);
  Solver certified{SolverKind::kCertified};
  // Ipopt believes that an iteration takes longer than what is left; the structured one fits.
  const SolveLimits limits{.deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5),
                           .iteration_time = 60.0};
  const Answer answer = certified.solve(start.ocp, start.guess, limits);
  EXPECT_EQ(answer.verdict, Verdict::kUnverified);
  EXPECT_EQ(answer.by, SolverKind::kStructured);
  EXPECT_EQ(answer.solution.status, SolveStatus::kConverged);
  // The next ones need no Ipopt.
  EXPECT_EQ(certified.solve(start.ocp, start.guess, limits).verdict, Verdict::kConfirmed);
}

// Ipopt believes that it has no time; the verdict then shows that it was asked.
TEST(Solver, IpoptIsAskedForTheFirstOfTwentySolutions) {
  const StartingPoint start = first_problem(random_case(1), false);
  RiccatiSolver structured;
  const Iterate found = structured.solve(start.ocp, start.guess, {.iterations = 300}).point;
  Solver certified{SolverKind::kCertified};
  int asked = 0;
  for (int i = 0; i < 60; ++i) {
    if (certified.confirms(start.ocp, found)) continue;
    const SolveLimits limits{.deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5),
                             .iteration_time = 60.0};
    asked += certified.solve(start.ocp, found, limits).verdict == Verdict::kUnverified ? 1 : 0;
  }
  EXPECT_EQ(asked, 3);
}

TEST(Solver, PlanTellsWhoseSolutionItIsAndWhetherItIsConfirmed) {
  NmpcParams params = unlimited();
  for (const char* solver : {"ipopt", "structured", "certified"}) {
    params.solver = solver;
    const Plan plan = solve_once(goal_request({3, 1, 0}), params);
    ASSERT_EQ(plan.status, PlanStatus::kOptimal);
    const bool by_ipopt = params.solver == "ipopt";
    EXPECT_EQ(plan.solver, by_ipopt ? SolverKind::kIpopt : SolverKind::kStructured);
    EXPECT_EQ(plan.confirmed, params.solver == "certified" ? 1 : 0);  // the winner
    EXPECT_EQ(plan.verdict,
              params.solver == "certified" ? Verdict::kConfirmed : Verdict::kUnverified);
    EXPECT_EQ(plan.disagreements, 0);
  }
  params.solver = "simplex";
  EXPECT_THROW(Nmpc(params, RobotParams{}), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::test
