// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/optimality.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <random>

#include "local_planner/planning_cases.hpp"
#include "support/instrumented.hpp"
#include "tandem/local_planner/solvers/ipopt_solve.hpp"
#include "tandem/local_planner/solvers/riccati_solver.hpp"

namespace tandem::test {
namespace {

bool is_accepted_by_ipopt(const Ocp& ocp, const Iterate& point) {
  const Solution end = ipopt_solve(ocp, point, {.iterations = 5});
  return end.status == SolveStatus::kConverged && end.iterations == 0;
}

// All values times 1 ± `by`.
Iterate disturbed(Iterate point, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> times(1.0 - by, 1.0 + by);
  for (auto* values : {&point.z, &point.lambda, &point.lower, &point.upper})
    for (double& value : *values) value *= times(random);
  return point;
}

// What takes the place of Ipopt in each cycle passes nothing that Ipopt would go on from.
TEST(Optimality, HoldsWhereIpoptTakesNoIteration) {
  RiccatiSolver solver;
  int accepted = 0, refused = 0, stricter = 0;
  for (unsigned seed = 40000; seed < 40000 + samples(150, 20); ++seed)
    for (const bool blind : {false, true}) {
      const StartingPoint start = first_problem(random_case(seed), blind);
      const Iterate found = solver.solve(start.ocp, start.guess, {.iterations = 300}).point;
      for (const double by : {0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2}) {
        const Iterate point = disturbed(found, by, seed);
        const bool ours = is_optimal(optimality_error(start.ocp, point));
        const bool ipopts = is_accepted_by_ipopt(start.ocp, point);
        EXPECT_TRUE(ipopts || !ours) << "seed " << seed << ", disturbed by " << by;
        ++(ipopts ? accepted : refused);
        stricter += ipopts && !ours ? 1 : 0;
      }
    }
  std::printf("Ipopt accepts %d, refuses %d; %d that it accepts we do not\n", accepted, refused,
              stricter);
  EXPECT_GT(accepted, refused / 10);
  EXPECT_GT(refused, accepted / 10);
  EXPECT_LE(stricter, 0.01 * accepted);
}

TEST(Optimality, SeesEachConditionThatFails) {
  RiccatiSolver solver;
  const StartingPoint start = first_problem(random_case(1), false);
  const Iterate found = solver.solve(start.ocp, start.guess, {.iterations = 300}).point;
  ASSERT_TRUE(is_optimal(optimality_error(start.ocp, found)));
  const auto broken = [&](auto&& spoil) {
    Iterate point = found;
    spoil(point);
    return optimality_error(start.ocp, point);
  };
  const auto far_off = broken([](Iterate& point) { point.z[kX] += 0.01; });
  EXPECT_NEAR(far_off.primal, 0.01, 1e-3);
  EXPECT_FALSE(is_optimal(far_off));
  EXPECT_GT(broken([](Iterate& point) { point.lambda[0] += 1.0; }).dual, 0.9);
  EXPECT_GT(broken([](Iterate& point) { point.lower[kSlack] += 1e6; }).complementarity, 0.1);
}

TEST(Optimality, IsNeverGivenToWhatIsNotFinite) {
  const StartingPoint start = first_problem(random_case(1), false);
  RiccatiSolver solver;
  Iterate point = solver.solve(start.ocp, start.guess, {.iterations = 300}).point;
  point.z[kV] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_optimal(optimality_error(start.ocp, point)));
}

}  // namespace
}  // namespace tandem::test
