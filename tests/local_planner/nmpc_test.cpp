// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/nmpc.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "local_planner/requests.hpp"
#include "tandem/local_planner/motion_check.hpp"
#include "tandem/local_planner/reference.hpp"
#include "tandem/model/diff_drive.hpp"

namespace tandem::test {
namespace {

TEST(Nmpc, PlanObeysTheDynamicsAndEveryLimit) {
  PlanRequest request = goal_request({3, 1, 1});
  request.command = request.measured = {0.3, 0.2};
  const std::vector<Obstacle> obstacles{pole(1.5, 0.3)};
  request.obstacles = obstacles;
  const NmpcParams params = unlimited();
  const RobotParams robot;
  const Plan plan = solve_once(request);
  ASSERT_EQ(plan.status, PlanStatus::kOptimal);
  ASSERT_EQ(plan.X_MB.size(), plan.twist.size() + 1);
  EXPECT_EQ(plan.command, plan.twist.front());
  Twist2 before = request.command;
  double period = params.control_period;
  for (std::size_t k = 0; k < plan.twist.size(); ++k) {
    const Pose2 next = integrate(plan.X_MB[k], plan.twist[k], params.dt);
    EXPECT_NEAR(next.x, plan.X_MB[k + 1].x, 1e-9);
    EXPECT_NEAR(next.y, plan.X_MB[k + 1].y, 1e-9);
    EXPECT_NEAR(next.theta, plan.X_MB[k + 1].theta, 1e-9);
    EXPECT_LE(std::abs(plan.twist[k].v - before.v), robot.a_max * period + 1e-9);
    EXPECT_LE(std::abs(plan.twist[k].w - before.w), robot.alpha_max * period + 1e-9);
    EXPECT_LE(plan.twist[k].v, robot.v_max + 1e-9);
    before = plan.twist[k];
    period = params.dt;
  }
}

TEST(Nmpc, AppliesNewParametersAndKeepsTheOldIfTheyContradict) {
  NmpcParams params = unlimited();
  Nmpc planner(params, {});
  PlanRequest request = goal_request({3, 0, 0});
  (void)planner.solve(request);
  NmpcParams wrong = params;
  wrong.control_period = 2.0 * wrong.dt;
  EXPECT_THROW(planner.set_params(wrong), std::invalid_argument);
  request.t += params.control_period;
  EXPECT_EQ(planner.solve(request).status, PlanStatus::kOptimal);
  params.horizon_steps /= 2;
  planner.set_params(params);
  request.t += params.control_period;
  const Plan plan = planner.solve(request);
  EXPECT_EQ(plan.status, PlanStatus::kOptimal);
  EXPECT_EQ(std::ssize(plan.twist), params.horizon_steps);
}

TEST(Nmpc, StartsFromThePosePredictedForTheDelay) {
  NmpcParams params = unlimited();
  params.delay = 0.3;
  PlanRequest request = goal_request({3, 0, 0});
  request.t = 5.0;
  request.command = request.measured = {0.5, 0.4};
  const Plan plan = solve_once(request, params);
  const Pose2 expected = integrate(request.X_MB, request.command, 0.3);
  EXPECT_DOUBLE_EQ(plan.t0, 5.3);
  EXPECT_NEAR(plan.X_MB.front().x, expected.x, 1e-12);
  EXPECT_NEAR(plan.X_MB.front().theta, expected.theta, 1e-12);
}

TEST(Nmpc, CommandInForceBeyondTheLimitsIsBroughtBack) {
  const RobotParams robot;
  for (const Twist2 command : {Twist2{1.5, 0.0}, Twist2{-1.0, 0.3}, Twist2{0.2, -2.5}}) {
    Nmpc planner(unlimited(), robot);
    PlanRequest request = goal_request({3, 0, 0});
    request.command = request.measured = command;
    const Plan plan = planner.solve(request);
    EXPECT_GE(static_cast<int>(plan.status), 0) << name(plan.status);
    EXPECT_LE(std::abs(plan.command.v - command.v), robot.a_max * 0.05 + 1e-9);
    if (command.v > robot.v_max) {
      EXPECT_LT(plan.command.v, command.v);
    }
    if (command.v < robot.v_min) {
      EXPECT_GT(plan.command.v, command.v);
    }
    if (command.w < -robot.w_max) {
      EXPECT_GT(plan.command.w, command.w);
    }
  }
}

TEST(Nmpc, PoleStraightAheadIsPassedOnOneSide) {
  PlanRequest request = goal_request({4, 0, 0});
  request.command = request.measured = {0.5, 0.0};
  const std::vector<Obstacle> obstacles{pole(1.5, 0.0)};
  request.obstacles = obstacles;
  const Plan plan = solve_once(request);
  ASSERT_EQ(plan.source, PlanSource::kSolution);
  EXPECT_LT(plan.slack, 1e-3);
  EXPECT_GT(plan.X_MB.back().x, 1.0);
  EXPECT_GT(std::abs(plan.X_MB.back().y), 0.3);
}

TEST(Nmpc, EveryCycleStartsFromManyGuessesAndReportsTheResult) {
  Nmpc planner(unlimited(), RobotParams{});
  PlanRequest request = goal_request({4, 0, 0});
  const std::vector<Obstacle> obstacles{pole(1.5, 0.0)};
  request.obstacles = obstacles;
  for (int i = 0; i < 20; ++i) {
    const Plan plan = planner.solve(request);
    ASSERT_EQ(plan.source, PlanSource::kSolution);
    EXPECT_GE(plan.guesses, 5) << "cycle " << i;  // last plan, left, right, wish, rest
    EXPECT_NEAR(plan.parts.pose + plan.parts.twist + plan.parts.change + plan.parts.slack,
                plan.cost, 1e-9 * plan.cost);
    EXPECT_GT(plan.parts.pose, 0.0);
    EXPECT_GE(plan.parts.slack, -1e-6);
    request.t += 0.05;
    request.X_MB = integrate(request.X_MB, plan.command, 0.05);
    request.command = request.measured = plan.command;
  }
  const Plan plan = planner.solve(request);
  EXPECT_GT(plan.active, 0);  // it passes close by
}

// With a preview the robot starts and turns together with the person; without one it waits until
// the leader has moved.
TEST(Nmpc, ChasesALeaderTheBetterForKnowingWhatThePersonDoes) {
  NmpcParams preview = unlimited(), none = unlimited();
  none.leader_preview = 0.0;
  for (const Method method : {Method::kLeader, Method::kPath}) {
    const PlanRequest request{.method = method, .X_MG = {0.02, 0.0, 0.0}, .user = {0.8, 0.5}};
    const Plan with = solve_once(request, preview), without = solve_once(request, none);
    EXPECT_GT(with.twist[3].v, without.twist[3].v + 0.05) << name(method);
    EXPECT_GT(with.X_MB[4].theta, without.X_MB[4].theta + 0.02) << name(method);
  }
}

TEST(Nmpc, RefusesALeaderWhosePersonIsNotANumber) {
  PlanRequest request{.method = Method::kPath, .X_MG = {1.0, 0.0, 0.0}};
  request.user = {std::nan(""), 0.0};
  EXPECT_EQ(solve_once(request).status, PlanStatus::kRefused);
  request.user = {1e300, -1e300};
  EXPECT_EQ(solve_once(request).source, PlanSource::kSolution);
}

// Passing on the left costs as much as on the right: the planner must choose one side and keep it.
TEST(Nmpc, DoesNotDitherBetweenTwoEqualPaths) {
  Nmpc planner(unlimited(), RobotParams{});
  PlanRequest request = goal_request({4, 0, 0});
  const std::vector<Obstacle> obstacles{pole(1.8, 0.0)};
  request.obstacles = obstacles;
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.01);
  int changes = 0;
  double side = 0.0;
  for (int i = 0; i < 80; ++i) {
    const Plan plan = planner.solve(request);
    request.t += 0.05;
    request.X_MB = integrate(request.X_MB, plan.command, 0.05);
    request.command = request.measured = plan.command;
    if (request.X_MB.x > 1.8) break;
    const auto beside =
        std::find_if(plan.X_MB.begin(), plan.X_MB.end(), [](const Pose2& X) { return X.x > 1.8; });
    if (beside != plan.X_MB.end()) {
      changes += side * beside->y < 0.0 ? 1 : 0;
      side = beside->y;
    }
    request.X_MB.y += noise(random);
    request.X_MB.theta += noise(random);
  }
  EXPECT_NE(side, 0.0);
  EXPECT_LE(changes, 1);
}

// A turn was commanded but is not visible in odometry yet.
TEST(Nmpc, CommandsUnderWayCountInThePredictedPose) {
  NmpcParams params = unlimited();
  params.delay = 0.3;
  Nmpc planner(params, RobotParams{});
  PlanRequest request = goal_request({3, 0, 0});
  const Twist2 sent[] = {{0.3, 0.1}, {0.3, 0.2}, {0.4, 0.3}, {0.4, 0.4}, {0.5, 0.5},
                         {0.5, 0.6}, {0.6, 0.6}, {0.6, 0.4}, {0.6, 0.2}, {0.6, 0.0}};
  Plan plan;
  for (const Twist2& command : sent) {
    request.t += 0.05;
    request.command = command;
    plan = planner.solve(request);
  }
  Pose2 expected = request.X_MB;
  for (int i = 4; i < 10; ++i) expected = integrate(expected, sent[i], 0.05);
  EXPECT_NEAR(plan.X_MB.front().x, expected.x, 1e-9);
  EXPECT_NEAR(plan.X_MB.front().y, expected.y, 1e-9);
  EXPECT_NEAR(plan.X_MB.front().theta, expected.theta, 1e-9);
}

TEST(Nmpc, KeepsFartherFromWhatMoves) {
  const auto least_gap = [](double speed) {
    Nmpc planner(unlimited(), RobotParams{});
    PlanRequest request = goal_request({4, 0, 0});
    double least = 1e9;
    for (; request.t < 6.0; request.t += 0.05) {
      Obstacle walker = pole(2.0 + speed * request.t, -0.6);
      walker.v_MO = {speed, 0.0};
      request.obstacles = std::span(&walker, 1);
      const Plan plan = planner.solve(request);
      request.command = request.measured = plan.command;
      request.X_MB = integrate(request.X_MB, plan.command, 0.05);
      least = std::min(least, (walker.p_MO - request.X_MB.position()).norm());
    }
    EXPECT_GT(request.X_MB.x, 3.0);
    return least;
  };
  EXPECT_GT(least_gap(0.06), least_gap(0.04) + 0.2);  // from 0.05 m/s on an obstacle moves
}

TEST(Nmpc, HeadingAcrossPiTurnsTheShortWay) {
  PlanRequest request = goal_request({0, 0, -3.0});
  request.X_MB = {0, 0, 3.0};
  const Plan plan = solve_once(request);
  ASSERT_EQ(plan.status, PlanStatus::kOptimal);
  EXPECT_GT(plan.command.w, 0.0);
  EXPECT_NEAR(wrap_angle(plan.X_MB.back().theta + 3.0), 0.0, 0.1);
}

TEST(Nmpc, WarmStartSurvivesTheMeasuredHeadingsJumpAtPi) {
  NmpcParams params = unlimited();
  params.extra_guesses = 0;  // only the iterations of the warm start count
  Nmpc planner(params, RobotParams{});
  PlanRequest request{.method = Method::kIntention, .X_MB = {0, 0, 3.1}, .user = {0.5, 0.6}};
  request.command = request.measured = {0.5, 0.6};
  for (int i = 0; i < 10; ++i) {
    const Plan plan = planner.solve(request);
    ASSERT_EQ(plan.status, PlanStatus::kOptimal);
    if (i > 0) {
      EXPECT_LE(plan.iterations, 4) << "cycle " << i;
    }
    request.t += 0.05;
    request.X_MB = integrate(request.X_MB, plan.command, 0.05);
    request.X_MB.theta = wrap_angle(request.X_MB.theta);
    request.command = request.measured = plan.command;
  }
}

TEST(Nmpc, WithoutObstaclesThePersonGetsExactlyWhatTheyAsk) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> v(-0.4, 0.8), w(-1.0, 1.0);
  for (int i = 0; i < 40; ++i) {
    PlanRequest request{
        .method = Method::kIntention, .X_MB = {1, 2, 3}, .user = {v(random), w(random)}};
    request.command = request.measured = {v(random), w(random)};
    const Plan plan = solve_once(request);
    const double braking = braking_of(request, RobotParams{});
    EXPECT_NEAR(plan.command.v, approach(request.command.v, request.user.v, 0.4, braking, 0.05),
                2e-3);
    EXPECT_NEAR(plan.command.w, approach(request.command.w, request.user.w, 0.4 * 0.05), 2e-3);
  }
}

TEST(Nmpc, KrijnensAtanFormPrefersThePersonsCurvature) {
  NmpcParams params = unlimited();
  params.intention_form = "atan";
  PlanRequest request{.method = Method::kIntention, .user = {0.5, 0.25}};
  request.command = request.measured = {0.5, 0.25};
  const Plan plan = solve_once(request, params);
  ASSERT_EQ(plan.status, PlanStatus::kOptimal);
  for (const Twist2& u : plan.twist) {
    EXPECT_NEAR(u.v, 0.5, 0.02);
    EXPECT_NEAR(u.w / u.v, 0.5, 0.03);
  }
}

TEST(Nmpc, FiftyObstaclesAreHandledLikeTheFewThatMatter) {
  std::vector<Obstacle> obstacles{pole(1.5, 0.2)};
  for (std::uint32_t i = 0; i < 49; ++i)
    obstacles.push_back(
        {i + 10, {-3.0 + 0.2 * i, i % 2 == 0 ? 2.5 : -2.5}, 0.2, 0.1, 0.3 * i, {0, 0}});
  PlanRequest many = goal_request({4, 0, 0}), few = many;
  many.obstacles = obstacles;
  few.obstacles = std::span(obstacles).first(1);
  const Plan a = solve_once(many), b = solve_once(few);
  ASSERT_EQ(a.status, PlanStatus::kOptimal);
  EXPECT_NEAR(a.cost, b.cost, 0.01 * b.cost);
}

TEST(Nmpc, GivesWayToAMovingObstacle) {
  PlanRequest request = goal_request({4, 0, 0});
  request.command = request.measured = {0.6, 0.0};
  std::vector<Obstacle> obstacles{pole(2.0, -1.5)};
  obstacles.front().v_MO = {0.0, 0.6};  // crosses the robot's way as it gets there
  request.obstacles = obstacles;
  const Plan plan = solve_once(request);
  ASSERT_EQ(plan.status, PlanStatus::kOptimal);
  const Body body{footprint_of(RobotParams{}), {}};
  EXPECT_TRUE(is_clear(body, {plan.X_MB.front(), 0.09, plan.dt, plan.twist}, obstacles, 3.5));
}

TEST(Nmpc, RejectsContradictingParameters) {
  NmpcParams params;
  params.control_period = 0.5;
  EXPECT_THROW(Nmpc(params, RobotParams{}), std::invalid_argument);
  params = {};
  params.time_budget = 0.001;
  EXPECT_THROW(Nmpc(params, RobotParams{}), std::invalid_argument);
  params = {};
  params.model = "heun";
  EXPECT_THROW(Nmpc(params, RobotParams{}), std::invalid_argument);
}

TEST(Plan, TwistAndPoseAreInterpolatedInTime) {
  Plan plan{.t0 = 2.0, .dt = 0.5};
  plan.twist = {{1.0, 0.0}, {0.5, 1.0}};
  plan.X_MB = {{0, 0, 0}, {0.5, 0, 0}, integrate({0.5, 0, 0}, {0.5, 1.0}, 0.5)};
  EXPECT_EQ(plan.at(1.0), (Twist2{1.0, 0.0}));
  EXPECT_EQ(plan.at(2.5), (Twist2{0.5, 1.0}));
  EXPECT_EQ(plan.at(3.1), Twist2{});
  EXPECT_DOUBLE_EQ(plan.pose_at(2.25).x, 0.25);
  EXPECT_EQ(plan.pose_at(9.0), plan.X_MB.back());
}

}  // namespace
}  // namespace tandem::test
