// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/riccati_solver.hpp"

#include <gtest/gtest.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include <array>
#include <cstdio>
#include <limits>
#include <map>

#include "local_planner/planning_cases.hpp"
#include "support/instrumented.hpp"
#include "tandem/local_planner/solvers/ipopt_solve.hpp"
#include "tandem/local_planner/solvers/optimality.hpp"

namespace tandem::test {
namespace {

// Runs `visit(begin, start)` for the four begins of a case. Warm ones follow from a cold solution.
template <class Visit>
void for_each_begin(unsigned seed, Visit&& visit) {
  const PlanningCase c = random_case(seed);
  const StartingPoint cold = first_problem(c, false);
  visit(Begin::kCold, cold);
  visit(Begin::kBlind, first_problem(c, true));
  RiccatiSolver solver;
  const Solved last{cold.ocp, solver.solve(cold.ocp, cold.guess, {.iterations = 300}).point, 0.0};
  visit(Begin::kWarm, next_problem(c, last, false, seed));
  visit(Begin::kMoved, next_problem(c, last, true, seed));
}

// The solver measures the same with a distance of its own for each row (4), which is off by the
// row's residual. Large multipliers multiply that.
constexpr double kAlmost = 1.01 * kTolerance;

bool is_optimal(const Ocp& ocp, const Solution& solution) {
  if (solution.status != SolveStatus::kConverged) return false;
  const OptimalityError error = optimality_error(ocp, solution.point);
  return error.primal <= kAlmost && error.complementarity <= 5.0 * kTolerance * error.scale &&
         error.dual <= kAlmost * error.scale;
}

int percentile(std::vector<int> values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

TEST(RandomCases, AreOfEveryMethodAndPathsHaveATrail) {
  std::map<Method, int> drawn;
  int trails = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    const PlanningCase c = random_case(seed);
    ++drawn[c.request.method];
    trails += trail_of(c, c.request, body_of(c.params, c.robot)).size() > 2 ? 1 : 0;
  }
  for (const Method method : {Method::kLeader, Method::kIntention, Method::kPath, Method::kGoal})
    EXPECT_GT(drawn[method], 60) << name(method);
  EXPECT_GT(trails, 0.9 * drawn[Method::kPath]);
}

TEST(RiccatiSolver, EndsInAnOptimumFromWarmColdAndInfeasibleStarts) {
  RiccatiSolver solver;
  std::array<std::vector<int>, 4> iterations;
  int optimal = 0, solves = 0;
  for (unsigned seed = 0; seed < samples(2500, 80); ++seed)
    for_each_begin(seed, [&](Begin begin, const StartingPoint& start) {
      const Solution& solution = solver.solve(start.ocp, start.guess, {.iterations = 300});
      iterations[static_cast<std::size_t>(begin)].push_back(solution.iterations);
      const bool good = is_optimal(start.ocp, solution);
      if (!good) std::printf("seed %u %s: %d iterations\n", seed, name(begin), solution.iterations);
      optimal += good ? 1 : 0;
      ++solves;
    });
  for (const Begin begin : kBegins) {
    const auto& all = iterations[static_cast<std::size_t>(begin)];
    std::printf("%-6s iterations p50 %d p90 %d p99 %d max %d\n", name(begin), percentile(all, 0.5),
                percentile(all, 0.9), percentile(all, 0.99), percentile(all, 1.0));
    EXPECT_LE(percentile(all, 0.99), 60) << name(begin);
  }
  EXPECT_LE(percentile(iterations[2], 0.5), 5);
  std::printf("%d of %d are optimal\n", optimal, solves);
  EXPECT_GE(optimal, solves * 0.9995);
}

double first_twists_apart(const Solution& a, const Solution& b) {
  return std::hypot(a.point.z[kV] - b.point.z[kV], a.point.z[kW] - b.point.z[kW]);
}

// Of the rows (4), which the slack takes up [m].
double largest_miss(const Ocp& ocp, const Solution& solution) {
  double miss = 0.0;
  for (std::size_t k = 0; k < ocp.stages.size(); ++k)
    miss = std::max(miss, at(ocp, solution.point.z, k, kSlack));
  return miss;
}

// What the barrier of 1e-4 leaves open: each bound and row may keep that much of the cost.
bool are_same(const Ocp& ocp, const Solution& a, const Solution& b) {
  const double cost_a = cost(ocp, a.point.z), cost_b = cost(ocp, b.point.z);
  return std::abs(cost_a - cost_b) <= 0.02 + 1e-4 * std::abs(cost_b) &&
         first_twists_apart(a, b) <= 0.01 &&
         std::abs(largest_miss(ocp, a) - largest_miss(ocp, b)) <= 1e-3;
}

// Whether each solver takes the other's end for an optimum: from there it goes nowhere.
bool confirm_each_other(const Ocp& ocp, const Solution& ours, const Solution& theirs) {
  RiccatiSolver solver;
  const Solution of_ours = ipopt_solve(ocp, ours.point, {.iterations = 300});
  const Solution of_theirs = solver.solve(ocp, theirs.point, {.iterations = 300});
  return of_ours.status == SolveStatus::kConverged && of_theirs.status == SolveStatus::kConverged &&
         are_same(ocp, of_ours, ours) && are_same(ocp, of_theirs, theirs);
}

// The two solvers may end in different minima of a problem that has several: then both are optimal,
// and each solver confirms the other's result. Such cases are counted, and neither solver may be
// worse more often than chance and starting point explain. If one of them does not converge, it is
// restarted from the other's result.
TEST(RiccatiSolver, AgreesWithIpopt) {
  RiccatiSolver solver;
  int agree = 0, better = 0, worse = 0, asked_again = 0, unverified = 0, unexplained = 0,
      missed = 0;
  for (unsigned seed = 10000; seed < 10000 + samples(700, 40); ++seed)
    for_each_begin(seed, [&](Begin begin, const StartingPoint& start) {
      const Ocp& ocp = start.ocp;
      Solution ours = solver.solve(ocp, start.guess, {.iterations = 300});
      Solution theirs = ipopt_solve(ocp, start.guess, {.iterations = 300});
      const bool ours_ended = ours.status == SolveStatus::kConverged;
      const bool theirs_ended = theirs.status == SolveStatus::kConverged;
      asked_again += ours_ended && theirs_ended ? 0 : 1;
      if (!theirs_ended && ours_ended) theirs = ipopt_solve(ocp, ours.point, {.iterations = 300});
      if (!ours_ended && theirs_ended) ours = solver.solve(ocp, theirs.point, {.iterations = 300});
      const double a = cost(ocp, ours.point.z), b = cost(ocp, theirs.point.z);
      const char* verdict = nullptr;
      if (!is_optimal(ocp, ours) || !is_optimal(ocp, theirs)) {
        ++unverified;
        verdict = "not judged";
      } else if (are_same(ocp, ours, theirs)) {
        ++agree;
      } else {
        ++(a < b ? better : worse);
        if (!confirm_each_other(ocp, ours, theirs)) {
          ++unexplained;
          verdict = "not explained";
        }
      }
      for (const Solution& solution : {ours, theirs})
        if (optimality_error(ocp, solution.point).primal > kAlmost) ++missed;
      if (verdict != nullptr)
        std::printf("seed %u %s: %g and %g %s\n", seed, name(begin), a, b, verdict);
    });
  const int all = agree + better + worse + unverified;
  std::printf(
      "%d problems: %d agree, another minimum: better %d, worse %d; asked again %d, not judged "
      "%d\n",
      all, agree, better, worse, asked_again, unverified);
  EXPECT_EQ(unexplained, 0);
  EXPECT_EQ(unverified, 0);
  EXPECT_EQ(missed, 0) << "constraints";
  EXPECT_LE(asked_again, all * 0.001);
  EXPECT_LE(worse, all * 0.03);
  EXPECT_LE(better + worse, all * 0.08);
}

// Another frame than the map's for the position's weights, as along a trail.
TEST(RiccatiSolver, EndsInAnOptimumWherePositionsAreWeighedInATurnedFrame) {
  RiccatiSolver solver;
  Random random{std::mt19937(17)};
  int iterations = 0;
  for (unsigned seed = 0; seed < samples(300, 20); ++seed) {
    StartingPoint start = first_problem(random_case(seed), false);
    for (Stage& stage : start.ocp.stages) {
      const double turn = random(-3, 3), along = random(0, 2), across = random(20, 60);
      const double c = std::cos(turn), s = std::sin(turn);
      stage.cost.q_x = along * c * c + across * s * s;
      stage.cost.q_y = along * s * s + across * c * c;
      stage.cost.q_xy = (along - across) * c * s;
    }
    const Solution& solution = solver.solve(start.ocp, start.guess, {.iterations = 300});
    EXPECT_TRUE(is_optimal(start.ocp, solution)) << seed;
    iterations += solution.iterations;
  }
  EXPECT_LE(iterations, 20 * static_cast<int>(samples(300, 20)));  // Newton, with the exact Hessian
}

TEST(RiccatiSolver, EqualCallsGiveEqualResultsBitForBit) {
  RiccatiSolver used;
  for (unsigned seed = 0; seed < samples(50, 10); ++seed)
    for_each_begin(seed, [&](Begin, const StartingPoint& start) {
      RiccatiSolver fresh;
      const Solution& a = used.solve(start.ocp, start.guess, {});
      const Solution& b = fresh.solve(start.ocp, start.guess, {});
      EXPECT_EQ(a.status, b.status);
      EXPECT_EQ(a.iterations, b.iterations);
      EXPECT_EQ(a.point.z, b.point.z);
      EXPECT_EQ(a.point.lambda, b.point.lambda);
    });
}

TEST(RiccatiSolver, StartedFromItsOwnSolutionNeedsNoIterationOrOne) {
  RiccatiSolver solver;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const StartingPoint start = first_problem(random_case(seed), false);
    const Iterate end = solver.solve(start.ocp, start.guess, {.iterations = 300}).point;
    EXPECT_LE(solver.solve(start.ocp, end, {}).iterations, 1) << seed;
  }
}

TEST(RiccatiSolver, StopsNearAKnownSolution) {
  RiccatiSolver solver;
  for (unsigned seed = 0; seed < 50; ++seed) {
    const StartingPoint start = first_problem(random_case(seed), true);
    const Solution alone = solver.solve(start.ocp, start.guess, {.iterations = 300});
    if (alone.status != SolveStatus::kConverged) continue;
    std::vector<KnownSolution> known{{alone.point, 0.1}};
    const SolveLimits limits{.iterations = 300, .known = known};
    const Solution again = solver.solve(start.ocp, start.guess, limits);
    EXPECT_EQ(again.status, SolveStatus::kKnown) << seed;
    EXPECT_LE(again.iterations, alone.iterations) << seed;
    for (std::size_t k = 0; k < start.ocp.stages.size(); ++k)
      EXPECT_LT((pose_after(start.ocp, again.point.z, k).position() -
                 pose_after(start.ocp, alone.point.z, k).position())
                    .norm(),
                0.1)
          << seed;
    std::vector<double>& far = known[0].point.z;
    for (std::size_t i = kX; i < far.size(); i += block(start.ocp)) far[i] += 1e6;
    EXPECT_EQ(solver.solve(start.ocp, start.guess, limits).point.z, alone.point.z) << seed;
  }
}

TEST(RiccatiSolver, StopsAtItsLimits) {
  RiccatiSolver solver;
  const StartingPoint start = first_problem(random_case(1), true);
  EXPECT_EQ(solver.solve(start.ocp, start.guess, {.iterations = 3}).iterations, 3);
  const SolveLimits late{.deadline = std::chrono::steady_clock::now()};
  const Solution& solution = solver.solve(start.ocp, start.guess, late);
  EXPECT_EQ(solution.status, SolveStatus::kTimeout);
  EXPECT_EQ(solution.iterations, 0);
  EXPECT_EQ(solution.point.z.size(), start.guess.z.size());
}

TEST(RiccatiSolver, FailsOnWhatIsNotFinite) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  RiccatiSolver solver;
  const StartingPoint good = first_problem(random_case(1), false);
  for (const double broken : {kNaN, kInfinite, -kInfinite}) {
    for (const int place : {0, 5, 7, 20}) {
      Iterate guess = good.guess;
      guess.z[static_cast<std::size_t>(place)] = broken;
      EXPECT_EQ(solver.solve(good.ocp, guess, {}).status, SolveStatus::kFailed);
    }
    std::vector<Ocp> bad(5, good.ocp);
    bad[0].X_MB.theta = broken;
    bad[1].command.v = broken;
    bad[2].stages[3].cost.q_x = broken;
    bad[3].v[2].min = broken == -kInfinite ? kNaN : broken;
    bad[4].stages[2].pairs.push_back({{0, 0}, 0.3, {1, {broken, 0.0}, 0.2, 0.1, 0.0, {0, 0}}, 0});
    for (const Ocp& ocp : bad)
      EXPECT_EQ(solver.solve(ocp, good.guess, {}).status, SolveStatus::kFailed);
  }
  EXPECT_EQ(solver.solve(good.ocp, good.guess, {}).status, SolveStatus::kConverged);
}

TEST(RiccatiSolver, SurvivesMultipliersWithoutMeaning) {
  RiccatiSolver solver;
  Random random{std::mt19937(3)};
  for (unsigned seed = 0; seed < 100; ++seed) {
    const StartingPoint start = first_problem(random_case(seed), false);
    Iterate guess = solver.solve(start.ocp, start.guess, {.iterations = 300}).point;
    for (auto* values : {&guess.lambda, &guess.lower, &guess.upper})
      for (double& value : *values) value = random.one_in(5) ? 0.0 : random(-1e6, 1e6);
    const Solution& solution = solver.solve(start.ocp, guess, {.iterations = 300});
    EXPECT_EQ(solution.status, SolveStatus::kConverged) << seed;
    guess.lower[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_LE(solver.solve(start.ocp, guess, {.iterations = 300}).iterations, 300);
  }
}

// Every number of a problem and of a guess that is zero, replaced.
StartingPoint with_tiny_for_zero(StartingPoint start, double tiny) {
  const auto replace = [&](double& value) { value = value == 0.0 ? tiny : value; };
  Ocp& ocp = start.ocp;
  for (double* value : {&ocp.X_MB.x, &ocp.X_MB.y, &ocp.X_MB.theta, &ocp.command.v, &ocp.command.w,
                        &ocp.motion.v, &ocp.motion.w, &ocp.gap_v, &ocp.gap_w})
    replace(*value);
  for (Stage& stage : ocp.stages) {
    StageCost& c = stage.cost;
    for (double* value : {&c.X_MR.x, &c.X_MR.y, &c.X_MR.theta, &c.twist.v, &c.twist.w, &c.change.v,
                          &c.change.w, &c.q_x, &c.q_y, &c.q_theta, &c.r_v, &c.r_w, &c.c_v, &c.c_w})
      replace(*value);
    for (Pair& pair : stage.pairs)
      for (double* value : {&pair.p_BC.x(), &pair.p_BC.y(), &pair.obstacle.p_MO.x(),
                            &pair.obstacle.p_MO.y(), &pair.obstacle.angle})
        replace(*value);
  }
  for (auto* values : {&start.guess.z, &start.guess.lambda, &start.guess.lower, &start.guess.upper})
    std::for_each(values->begin(), values->end(), replace);
  return start;
}

// A robot at the origin of the map with everything at rest, and a goal on its axis.
StartingPoint full_of_zeros(unsigned seed) {
  PlanningCase c = random_case(seed);
  c.request.X_MB = {};
  c.request.command = c.request.measured = c.request.user = {};
  c.request.X_MG = {seed % 2 == 0 ? 2.0 : 0.0, 0.0, 0.0};
  for (Obstacle& obstacle : c.obstacles) obstacle.v_MO.setZero();
  return first_problem(c, false);
}

// Denormal numbers are to be what they stand for, zeros: the same iterations to the same end. The
// processor's own way to take them so, FTZ and DAZ, is not asked for: it is a setting of the whole
// thread, Ipopt's arithmetic included, and there would be nothing for it to do, as shown below.
TEST(RiccatiSolver, TakesDenormalsForZeros) {
  RiccatiSolver solver;
  constexpr double kTiny = 1e-310;
  static_assert(kTiny > 0.0 && kTiny < std::numeric_limits<double>::min());
  for (unsigned seed = 0; seed < samples(300, 20); ++seed) {
    const StartingPoint zeros = full_of_zeros(seed);
    const Solution expected = solver.solve(zeros.ocp, zeros.guess, {.iterations = 300});
    ASSERT_EQ(expected.status, SolveStatus::kConverged) << seed;
    for (const double tiny : {kTiny, -kTiny}) {
      const StartingPoint start = with_tiny_for_zero(zeros, tiny);
      const Solution& solution = solver.solve(start.ocp, start.guess, {.iterations = 300});
      EXPECT_TRUE(is_optimal(start.ocp, solution)) << seed;
      EXPECT_EQ(solution.iterations, expected.iterations) << seed;
      for (std::size_t i = 0; i < expected.point.z.size(); ++i)
        ASSERT_NEAR(solution.point.z[i], expected.point.z[i], 1e-6) << seed;
    }
  }
}

#if defined(__SSE2__)
constexpr unsigned kDenormal = 0x02, kUnderflow = 0x10, kFlags = 0x3f;  // of MXCSR

// What the processor remembers of `f`: whether an operand was denormal, or a result.
template <class F>
unsigned denormals_of(F&& f) {
  _mm_setcsr(_mm_getcsr() & ~kFlags);
  f();
  return _mm_getcsr() & (kDenormal | kUnderflow);
}

TEST(RiccatiSolver, ComesToNoDenormalByItself) {
  volatile double tiny = 1e-310;
  ASSERT_EQ(denormals_of([&] { tiny = 3.0 * tiny; }) & kDenormal, kDenormal) << "is not seen";
  RiccatiSolver solver;
  int solves = 0, denormal = 0;
  for (unsigned seed = 0; seed < samples(1000, 50); ++seed)
    for_each_begin(seed, [&](Begin, const StartingPoint& start) {
      const auto solve = [&] { (void)solver.solve(start.ocp, start.guess, {.iterations = 300}); };
      denormal += denormals_of(solve) != 0 ? 1 : 0;
      ++solves;
    });
  std::printf("%d of %d solves come to a denormal number\n", denormal, solves);
  EXPECT_LE(denormal, solves / 1000);
}
#endif

TEST(RiccatiSolver, TakesDenormalMultipliersForZeros) {
  RiccatiSolver solver;
  for (unsigned seed = 0; seed < samples(300, 20); ++seed) {
    const StartingPoint start = first_problem(random_case(seed), false);
    const Iterate end = solver.solve(start.ocp, start.guess, {.iterations = 300}).point;
    const auto from = [&](double multiplier) {
      Iterate guess = end;
      for (auto* values : {&guess.lambda, &guess.lower, &guess.upper})
        values->assign(values->size(), multiplier);
      return Solution{solver.solve(start.ocp, guess, {.iterations = 300})};
    };
    const Solution zeros = from(0.0);
    for (const double tiny : {1e-310, -1e-310}) {
      const Solution solution = from(tiny);
      EXPECT_EQ(solution.status, zeros.status) << seed;
      EXPECT_EQ(solution.iterations, zeros.iterations) << seed;
      EXPECT_LE(first_twists_apart(solution, zeros), 1e-6) << seed;
    }
  }
}

TEST(RiccatiSolver, KeepsAVariableWhoseBoundsMeet) {
  RiccatiSolver solver;
  StartingPoint start = first_problem(random_case(2), false);
  for (Interval& range : start.ocp.w) range = {0.0, 0.0};
  start.ocp.command.w = 0.0;
  const Solution& solution = solver.solve(start.ocp, start.guess, {.iterations = 300});
  EXPECT_EQ(solution.status, SolveStatus::kConverged);
  for (int k = 0; k < start.ocp.horizon(); ++k)
    EXPECT_NEAR(at(start.ocp, solution.point.z, static_cast<std::size_t>(k), kW), 0.0, 1e-5);
}

}  // namespace
}  // namespace tandem::test
