// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/reference.hpp"

#include <gtest/gtest.h>

#include "tandem/model/diff_drive.hpp"

namespace tandem::test {
namespace {

// Followed from its start, a straight trail of 3 m.
std::vector<StageCost> costs_along(double direction, const NmpcParams& params) {
  std::vector<Eigen::Vector2d> trail;
  const Eigen::Vector2d ahead{std::cos(direction), std::sin(direction)};
  for (int i = 0; i <= 60; ++i) trail.push_back(0.05 * i * ahead);
  const PlanRequest request{.method = Method::kPath,
                            .X_MG = {3.0 * ahead.x(), 3.0 * ahead.y(), direction},
                            .trail = trail};
  const RobotParams robot;
  const Forecast nominal = forecast(request, {{0.0, 0.0, direction}, {}}, params, robot);
  return stage_costs(request, nominal, params, robot);
}

// Of the position alone.
double cost_at(const StageCost& cost, const Eigen::Vector2d& off) {
  return off.dot(cost.pull(off));
}

TEST(PathCost, WeighsErrorsAcrossAndAlongTheTrailByTheirOwnWeights) {
  NmpcParams params;
  params.weight_across = 7.0;
  params.weight_along = 2.0;
  for (const double direction : {0.0, 0.7, 1.5708, -2.5})
    for (const StageCost& cost : costs_along(direction, params)) {
      const Eigen::Vector2d along{std::cos(direction), std::sin(direction)};
      const Eigen::Vector2d across{-along.y(), along.x()};
      EXPECT_NEAR(cost_at(cost, 0.3 * along), 2.0 * 0.09, 1e-9) << direction;
      EXPECT_NEAR(cost_at(cost, 0.3 * across), 7.0 * 0.09, 1e-9) << direction;
      EXPECT_NEAR(cost_at(cost, 0.3 * (along + across)), 9.0 * 0.09, 1e-9) << direction;
    }
}

TEST(PathCost, IsTheSameInEveryFrameWhereTheWeightsAreEqual) {
  NmpcParams params;
  params.weight_across = params.weight_along = 5.0;
  for (const StageCost& cost : costs_along(0.7, params)) {
    EXPECT_NEAR(cost.q_x, 5.0, 1e-12);
    EXPECT_NEAR(cost.q_y, 5.0, 1e-12);
    EXPECT_NEAR(cost.q_xy, 0.0, 1e-12);
  }
}

TEST(Forecast, BrakesAsHardAsTheRobotCanForAStickThatAsksForFarLess) {
  const RobotParams robot;
  const NmpcParams params;
  const auto speed_after = [&](const Twist2& user, Method method) {  // the first stage
    const PlanRequest request{.method = method, .command = {0.8, 0.0}, .user = user};
    return forecast(request, {{}, {}}, params, robot).twist.front().v;
  };
  const double period = params.control_period;
  EXPECT_NEAR(speed_after({0.2, 0.0}, Method::kIntention), 0.8 - robot.a_brake * period, 1e-12);
  EXPECT_NEAR(speed_after({-0.4, 0.0}, Method::kIntention), 0.8 - robot.a_brake * period, 1e-12);
  EXPECT_NEAR(speed_after({-0.4, 0.0}, Method::kLeader), 0.8 - robot.a_brake * period, 1e-12);
  EXPECT_NEAR(speed_after({0.7, 0.0}, Method::kIntention), 0.8 - robot.a_max * period, 1e-12);
  EXPECT_NEAR(speed_after({}, Method::kGoal), 0.8 - robot.a_max * period, 1e-12);
}

// Braked within a stage, it gains speed the other way for the rest of it only.
TEST(Approach, BrakesTowardRestAndGainsSpeedComfortablyBeyond) {
  EXPECT_NEAR(approach(0.3, -1.0, 0.4, 1.5, 0.25), -0.4 * 0.05, 1e-12);
  EXPECT_NEAR(approach(-0.3, 1.0, 0.4, 1.5, 0.25), 0.4 * 0.05, 1e-12);
  EXPECT_NEAR(approach(0.8, 0.2, 0.4, 1.5, 0.25), 0.8 - 1.5 * 0.25, 1e-12);
  EXPECT_NEAR(approach(0.3, 0.2, 0.4, 1.5, 0.25), 0.2, 1e-12);
  EXPECT_NEAR(approach(0.2, 0.8, 0.4, 1.5, 0.25), 0.2 + 0.4 * 0.25, 1e-12);
  EXPECT_NEAR(approach(0.0, -0.8, 0.4, 1.5, 0.25), -0.4 * 0.25, 1e-12);
}

// Straight on, round a bend, on the spot.
TEST(LeaderAfter, GoesOnAsItIsDrivenForThePreviewAtMost) {
  NmpcParams params;
  params.leader_preview = 0.5;
  for (const Twist2& user : {Twist2{0.8, 0.0}, Twist2{0.6, -0.9}, Twist2{0.0, 1.0}}) {
    const PlanRequest request{.method = Method::kLeader, .X_MG = {1.0, 2.0, 0.7}, .user = user};
    const Pose2 now = leader_after(0.0, request, params);
    const Pose2 soon = leader_after(1e-4, request, params);
    EXPECT_EQ(now.position(), request.X_MG.position());
    EXPECT_NEAR((soon.position() - now.position()).norm(), 1e-4 * user.v, 1e-7);
    EXPECT_NEAR(soon.theta - now.theta, 1e-4 * user.w, 1e-7);
    const Pose2 ever = leader_after(1e9, request, params);
    EXPECT_NEAR((ever.position() - integrate(request.X_MG, user, 0.5).position()).norm(), 0, 1e-12);
    EXPECT_NEAR(ever.theta, 0.7 + 0.5 * user.w, 1e-12);
  }
}

TEST(LeaderAfter, LeadsThereByPointsOfTheTrail) {
  NmpcParams params;
  params.leader_preview = 0.5;
  const PlanRequest request{.method = Method::kPath, .X_MG = {1.0, 2.0, 0.7}, .user = {0.62, -0.9}};
  const auto onward = leader_onward(request, params);
  ASSERT_EQ(onward.size(), 6u);  // of 0.31 m
  const Pose2 ever = leader_after(1e9, request, params);
  EXPECT_NEAR((onward.back() - ever.position()).norm(), 0.0, 1e-12);
  Eigen::Vector2d before = request.X_MG.position();
  for (const Eigen::Vector2d& p : onward) {
    EXPECT_NEAR((p - before).norm(), 0.05, 2e-3);
    before = p;
  }
}

TEST(LeaderAfter, StaysWithoutAPreviewAndAGoalStaysAnyway) {
  NmpcParams params;
  PlanRequest request{.method = Method::kGoal, .X_MG = {1.0, 2.0, 0.7}, .user = {0.8, 0.3}};
  EXPECT_EQ(leader_after(1e9, request, params).position(), request.X_MG.position());
  request.method = Method::kLeader;
  params.leader_preview = 0.0;
  EXPECT_EQ(leader_after(1e9, request, params).position(), request.X_MG.position());
  EXPECT_TRUE(leader_onward(request, params).empty());
}

}  // namespace
}  // namespace tandem::test
