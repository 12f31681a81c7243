// SPDX-License-Identifier: Apache-2.0
// Tests that broken requests, a busy machine, other planners and past cycles do not disturb the
// planner.
#include <gtest/gtest.h>
#include <time.h>

#include <atomic>
#include <limits>
#include <random>
#include <thread>

#include "local_planner/requests.hpp"
#include "support/instrumented.hpp"
#include "tandem/local_planner/nmpc.hpp"

namespace tandem::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Nmpc, RefusesNonFiniteRequestsAndBrakes) {
  const RobotParams robot;
  Nmpc planner(unlimited(), robot);
  PlanRequest good = goal_request({3, 0, 0});
  good.command = good.measured = {0.5, 0.0};
  std::vector<PlanRequest> bad(5, good);
  bad[0].X_MG.y = kNaN;
  bad[1].X_MB.theta = kNaN;
  bad[2].t = std::numeric_limits<double>::infinity();
  bad[3].command.w = kNaN;
  const std::vector<Obstacle> broken{{1, {kNaN, 0}, 0.2, 0.2, 0.0, {0, 0}}};
  bad[4].obstacles = broken;
  for (const PlanRequest& request : bad) {
    const Plan plan = planner.solve(request);
    EXPECT_EQ(plan.status, PlanStatus::kRefused);
    EXPECT_EQ(plan.source,
              is_finite(request.command) ? PlanSource::kBraking : PlanSource::kStanding);
    EXPECT_TRUE(is_finite(plan.command));
    EXPECT_LT(plan.command.v, 0.5);
    EXPECT_EQ(plan.twist.back(), Twist2{});
  }
  EXPECT_EQ(planner.solve(good).status, PlanStatus::kOptimal);
}

TEST(Nmpc, RefusesAnEllipseWithoutExtent) {
  PlanRequest request = goal_request({3, 0, 0});
  const std::vector<Obstacle> flat{{1, {1, 0}, 1.0, 0.0, 0.0, {0, 0}}};
  request.obstacles = flat;
  EXPECT_EQ(solve_once(request).status, PlanStatus::kRefused);
}

TEST(Nmpc, EqualRequestsGiveEqualPlansBitForBit) {
  Nmpc first(unlimited(), RobotParams{}), second(unlimited(), RobotParams{});
  const std::vector<Obstacle> obstacles{pole(1.5, 0.1), pole(2.5, -0.4)};
  PlanRequest request = goal_request({4, 0, 0});
  request.obstacles = obstacles;
  for (int i = 0; i < 60; ++i) {
    const Plan a = first.solve(request), b = second.solve(request);
    ASSERT_EQ(a.twist, b.twist);
    ASSERT_EQ(a.X_MB, b.X_MB);
    request.t += 0.05;
    request.X_MB = integrate(request.X_MB, a.command, 0.05);
    request.command = request.measured = a.command;
  }
}

// First on a machine so busy that no solve can finish, then on a free one.
TEST(Nmpc, RecoversFromTwoHundredFailingSolves) {
  NmpcParams starved = unlimited();
  starved.max_iterations = 1;
  starved.extra_guesses = 0;
  Nmpc planner(starved, RobotParams{});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-3, 3);
  const auto pose = [&] { return Pose2{place(random), place(random), place(random)}; };
  constexpr int kMaxCycles = 2000;
  int failed = 0;
  double t = 0.0;
  for (int i = 0; i < kMaxCycles && failed < 200; ++i, t += 0.05) {
    PlanRequest request = goal_request(pose());
    std::vector<Obstacle> obstacles;
    for (int k = 0; k < 20; ++k) obstacles.push_back(pole(place(random), place(random)));
    request.obstacles = obstacles;
    request.t = t;
    request.X_MB = pose();
    const Plan plan = planner.solve(request);
    failed += static_cast<int>(plan.status) < 0 ? 1 : 0;
    EXPECT_TRUE(is_finite(plan.command));
  }
  ASSERT_EQ(failed, 200);
  PlanRequest still = goal_request({2, 1, 0});
  still.t = t;
  Plan plan;
  for (int i = 0; i < 60; ++i) plan = planner.solve(still), still.t += 0.05;
  EXPECT_GE(static_cast<int>(plan.status), 0);  // one iteration a cycle, from its own last point
}

TEST(Nmpc, TeleportingRobotGetsAColdStart) {
  Nmpc planner(unlimited(), RobotParams{});
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-3, 3);
  int failed = 0;
  for (int i = 0; i < 100; ++i) {
    PlanRequest request = goal_request({3, 0, 0});
    request.t = 0.05 * i;
    request.X_MB = {place(random), place(random), place(random)};
    failed += static_cast<int>(planner.solve(request).status) < 0 ? 1 : 0;
  }
  EXPECT_LE(failed, 1);
}

// One iteration that is preempted must not make the planner give up permanently.
TEST(Nmpc, ABudgetThatWasOnceTooShortDoesNotLockItOut) {
  NmpcParams params = default_params();
  params.time_budget = 0.02;
  Nmpc planner(params, RobotParams{});
  PlanRequest request = goal_request({3, 1, 0});
  std::vector<std::thread> load;
  std::atomic<bool> busy{true};
  for (int i = 0; i < 8; ++i)
    load.emplace_back([&] {
      while (busy) {
      }
    });
  for (int i = 0; i < 40; ++i, request.t += 0.05) (void)planner.solve(request);
  busy = false;
  for (auto& thread : load) thread.join();
  int good = 0;
  for (int i = 0; i < 40; ++i, request.t += 0.05)
    good += static_cast<int>(planner.solve(request).status) >= 0 ? 1 : 0;
  EXPECT_GT(good, 20);
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// An instrumented check takes longer than its reserve.
constexpr double kOverrun = test::kInstrumented ? 0.200 : 0.001;  // [s]

// Counted in processor time, which on an idle machine is the wall clock's: what the machine takes
// away between two looks at the clock is not the planner's to keep.
TEST(Nmpc, KeepsItsTimeBudget) {
  NmpcParams params = default_params();
  params.time_budget = 0.02;
  Nmpc planner(params, RobotParams{});
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-3, 3);
  for (int i = 0; i < 100; ++i) {
    std::vector<Obstacle> obstacles;
    for (int k = 0; k < 25; ++k) obstacles.push_back(pole(place(random), place(random)));
    PlanRequest request = goal_request({place(random), place(random), 0});
    request.t = 10.0 * i;  // always cold
    request.obstacles = obstacles;
    const double before = thread_seconds();
    (void)planner.solve(request);
    EXPECT_LT(thread_seconds() - before, params.time_budget + kOverrun) << "cycle " << i;
  }
}

TEST(Nmpc, PlannersInSeveralThreadsDoNotDisturbEachOther) {
  const Plan expected = solve_once(goal_request({3, 1, 0}));
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (std::size_t i = 0; i < wrong.size(); ++i)
    threads.emplace_back([&, i] {
      for (int k = 0; k < 10; ++k)
        wrong[i] += solve_once(goal_request({3, 1, 0})).twist == expected.twist ? 0 : 1;
    });
  for (auto& thread : threads) thread.join();
  for (const int count : wrong) EXPECT_EQ(count, 0);
}

}  // namespace
}  // namespace tandem::test
