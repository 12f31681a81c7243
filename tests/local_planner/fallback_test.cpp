// SPDX-License-Identifier: Apache-2.0
// Tests the planner when no new plan may be driven.
#include "tandem/local_planner/fallback.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "local_planner/requests.hpp"
#include "tandem/local_planner/motion_check.hpp"
#include "tandem/local_planner/nmpc.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem::test {
namespace {

TEST(Nmpc, BrakesImmediatelyForAnObstacleThatAppearsInFront) {
  Nmpc planner(unlimited(), RobotParams{});
  PlanRequest request = goal_request({4, 0, 0});
  request.command = request.measured = {0.8, 0.0};
  ASSERT_EQ(planner.solve(request).status, PlanStatus::kOptimal);
  request.t = 0.05;
  request.X_MB.x = 0.04;
  const std::vector<Obstacle> obstacles{pole(1.25, 0.0)};  // 0.5 m ahead; comfort needs 0.8 m
  request.obstacles = obstacles;
  const Plan plan = planner.solve(request);
  EXPECT_LT(static_cast<int>(plan.status), 0);
  EXPECT_EQ(plan.source, PlanSource::kBraking);
  EXPECT_LT(plan.command.v, 0.8 - 0.4 * 0.05 - 1e-6);  // harder than comfort
  const Body body{footprint_of(RobotParams{}), {}};
  EXPECT_FALSE(touches(body, plan.X_MB.back(), obstacles.front()));
}

// A goal so far away that its cost is not finite: finite requests that no solver can answer.
TEST(Nmpc, GoesDownTheLadderRungByRungWhereNoSolverAnswers) {
  for (const char* solver : {"ipopt", "structured", "certified"}) {
    NmpcParams params = unlimited();
    params.solver = solver;
    Nmpc planner(params, RobotParams{});
    PlanRequest request = goal_request({4, 0, 0});
    request.command = request.measured = {0.6, 0.0};
    const Plan good = planner.solve(request);
    ASSERT_EQ(good.source, PlanSource::kSolution);

    request.X_MG.x = 1e200;
    request.t = 0.05;
    request.X_MB = good.pose_at(0.05);
    request.command = request.measured = good.command;
    const Plan rest = planner.solve(request);
    EXPECT_EQ(rest.source, PlanSource::kPrevious);
    EXPECT_LT(static_cast<int>(rest.status), 0);
    EXPECT_NEAR(rest.command.v, good.at(0.05).v, 1e-9);
    EXPECT_EQ(rest.twist.back(), Twist2{});

    const std::vector<Obstacle> in_the_way{pole(request.X_MB.x + 1.1, 0.0)};
    request.obstacles = in_the_way;
    const Plan braking = planner.solve(request);  // the rest of the plan is checked again
    EXPECT_EQ(braking.source, PlanSource::kBraking);
    EXPECT_LT(braking.command.v, request.command.v);
    EXPECT_GT(braking.command.v, 0.0);

    request.t = 2.0;  // the plan is too old
    request.command = request.measured = {};
    const Plan standing = planner.solve(request);
    EXPECT_EQ(standing.source, PlanSource::kStanding);
    EXPECT_EQ(standing.command, Twist2{});
    EXPECT_EQ(standing.cost, 0.0);
    for (const Plan& plan : {rest, braking, standing})
      EXPECT_EQ(plan.verdict, Verdict::kUnverified);
  }
}

TEST(Nmpc, EachRungHasItsName) {
  std::set<std::string> names;
  for (const PlanSource source :
       {PlanSource::kSolution, PlanSource::kPrevious, PlanSource::kBraking, PlanSource::kYielded,
        PlanSource::kResting, PlanSource::kStanding})
    names.insert(name(source));
  EXPECT_EQ(names, (std::set<std::string>{"solution", "previous", "braking", "yielded", "resting",
                                          "standing"}));
}

// What the robot is asked for is as much less than it does as it can brake until that acts: less is
// what comfort asks for, and from rest it goes on where it is. The arc stays the same.
TEST(Nmpc, BrakesAsHardAsTheRobotCanWhileTheStickIsAtRest) {
  const RobotParams robot;
  for (const Method method : {Method::kLeader, Method::kPath, Method::kIntention}) {
    Nmpc planner(unlimited(), robot);
    PlanRequest request = goal_request({1.2, 0.0, 0.0});
    request.method = method;
    request.rests = true;
    request.command = request.measured = {0.6, 0.3};
    const Plan plan = planner.solve(request);
    EXPECT_EQ(plan.source, PlanSource::kResting);
    EXPECT_FALSE(is_fallback(plan.source));
    EXPECT_LT(plan.command.v, 0.6 - robot.a_brake * 0.1);
    EXPECT_GT(plan.command.v, 0.0);
    EXPECT_NEAR(plan.command.w / plan.command.v, 0.5, 1e-9);

    request.command = {0.1, -0.1};  // brakes already, and has been sent the other way
    const Plan later = planner.solve(request);
    EXPECT_EQ(later.command.v, 0.1);
    EXPECT_EQ(later.command.w, 0.0);

    request.measured = {};
    EXPECT_EQ(planner.solve(request).command, Twist2{});
  }
}

TEST(Nmpc, AGoalIsDrivenToWhetherAStickIsAtRestOrNot) {
  Nmpc planner(unlimited(), RobotParams{});
  PlanRequest request = goal_request({4, 0, 0});
  request.rests = true;
  EXPECT_GT(planner.solve(request).command.v, 0.0);
}

// Whatever is planned, the robot stands; only where the filter says that it refuses the plans, for
// what is near, is that a deadlock.
TEST(Nmpc, YieldsToThePersonWhileItsPlansAreRefused) {
  for (const auto& [method, refused] :
       {std::pair{Method::kIntention, true}, {Method::kIntention, false}, {Method::kGoal, true}}) {
    Nmpc planner(unlimited(), RobotParams{});
    PlanRequest request = goal_request({4, 0, 0});
    request.method = method;
    request.user = {-0.2, 0.3};
    request.refused = refused;
    double yielded_at = -1.0;
    for (; request.t < 2.0; request.t += 0.05) {
      const Plan plan = planner.solve(request);
      if (plan.source != PlanSource::kYielded || yielded_at >= 0.0) continue;
      yielded_at = request.t;
      EXPECT_LT(plan.command.v, 0.0);
      EXPECT_GT(plan.command.w, 0.0);
    }
    if (method == Method::kIntention && refused)
      EXPECT_NEAR(yielded_at, 0.6, 0.11);
    else
      EXPECT_LT(yielded_at, 0.0);
  }
}

TEST(Nmpc, DoesNotYieldWhileItsPlansComeThrough) {
  Nmpc planner(unlimited(), RobotParams{});
  PlanRequest request = goal_request({4, 0, 0});
  request.method = Method::kIntention;
  request.user = {0.5, 0.0};
  for (; request.t < 2.0; request.t += 0.05) {
    const Plan plan = planner.solve(request);
    EXPECT_EQ(plan.source, PlanSource::kSolution);
    request.command = request.measured = plan.command;
    request.X_MB = integrate(request.X_MB, plan.command, 0.05);
  }
}

// A shape may reach into the outline, because fitted shapes are larger than what they enclose.
TEST(Nmpc, InsideAShapeItMovesOutAndNeverDeeper) {
  const Body body{footprint_of(RobotParams{}), {}};
  for (const double x : {0.55, 0.62, 0.70}) {  // outline's front at 0.483, pole's rim at x − 0.225
    Nmpc planner(unlimited(), RobotParams{});
    PlanRequest request = goal_request({2, 0, 0});
    const std::vector<Obstacle> obstacles{pole(x, 0.0)};
    request.obstacles = obstacles;
    double untouched = 0.0;  // radius of the pole that the outline would leave untouched
    for (int i = 0; i < 40; ++i) {
      const Plan plan = planner.solve(request);
      request.t += 0.05;
      request.X_MB = integrate(request.X_MB, plan.command, 0.05);
      request.command = request.measured = plan.command;
      const double now = passable(body, {.X_MB = request.X_MB}, obstacles).front().a;
      EXPECT_GE(now, untouched - 0.003) << "pole at " << x << " cycle " << i;
      untouched = std::max(untouched, now);
    }
    EXPECT_FALSE(touches(body, request.X_MB, obstacles.front())) << "pole at " << x;
  }
}

}  // namespace
}  // namespace tandem::test
