// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tandem/local_planner/plan_inputs.hpp"

namespace tandem {
namespace {

constexpr Twist2 kPush{0.5, 0.1};
constexpr Twist2 kSent{0.4, 0.0};
constexpr Pose2 kLeader{1.0, 2.0, 0.3};
constexpr Pose2 kGoal{4.0, 5.0, 0.6};
constexpr Method kMethods[] = {Method::kLeader, Method::kPath, Method::kIntention, Method::kGoal};
const RobotState kRobot{{0.1, 0.2, 0.3}, {0.35, 0.0}, 10.0};

// Everything received at 10 s.
PlanInputs complete() {
  PlanInputs inputs{{.user_timeout = 0.12, .obstacle_timeout = 0.1, .in_force_timeout = 0.2}};
  inputs.on_obstacles({{1, {2.0, 0.0}, 0.2, 0.2, 0.0, {0.0, 0.0}}}, 10.0);
  inputs.on_user(kPush, 10.0);
  inputs.on_command(kSent, 10.0);
  inputs.on_leader(kLeader, 10.0);
  inputs.on_goal(kGoal);
  inputs.on_filter(true, true, 10.0);
  return inputs;
}

TEST(PlanInputs, SufficeOnlyIfTheMethodsOwnInputsAreRecent) {
  const PlanInputs inputs = complete();
  for (const Method method : kMethods) {
    EXPECT_FALSE(inputs.missing(method, 10.05));
    EXPECT_EQ(inputs.missing(method, 10.11), Reason::kObstaclesSilent);
  }
  PlanInputs seen = complete();
  seen.on_obstacles({}, 10.2);
  EXPECT_EQ(seen.missing(Method::kLeader, 10.2), Reason::kLeaderSilent);
  EXPECT_EQ(seen.missing(Method::kPath, 10.2), Reason::kLeaderSilent);
  EXPECT_EQ(seen.missing(Method::kIntention, 10.2), Reason::kUserSilent);
  EXPECT_FALSE(seen.missing(Method::kGoal, 10.2));
}

TEST(PlanInputs, AGoalMustHaveBeenGiven) {
  PlanInputs inputs{{}};
  inputs.on_obstacles({}, 10.0);
  EXPECT_EQ(inputs.missing(Method::kGoal, 10.0), Reason::kNoGoal);
}

TEST(PlanInputs, MakeARequestOfTheRecentOnes) {
  const PlanInputs inputs = complete();
  const PlanRequest request = inputs.request(Method::kLeader, kRobot, 10.05);
  EXPECT_EQ(request.method, Method::kLeader);
  EXPECT_EQ(request.t, 10.05);
  EXPECT_EQ(request.X_MB, kRobot.X_MB);
  EXPECT_EQ(request.measured, kRobot.twist);
  EXPECT_EQ(request.command, kSent);
  EXPECT_EQ(request.user, kPush);
  EXPECT_FALSE(request.rests);
  EXPECT_EQ(request.X_MG, kLeader);
  EXPECT_EQ(request.obstacles.size(), 1U);
  EXPECT_TRUE(request.guarded && request.refused);
  EXPECT_EQ(inputs.request(Method::kGoal, kRobot, 10.05).X_MG, kGoal);
}

TEST(PlanInputs, LeaveOutWhatIsTooOld) {
  const PlanInputs inputs = complete();
  const PlanRequest request = inputs.request(Method::kGoal, kRobot, 10.3);
  EXPECT_EQ(request.command, Twist2{});
  EXPECT_EQ(request.user, Twist2{});
  EXPECT_FALSE(request.rests) << "the person is silent, which is no rest";
  EXPECT_FALSE(request.guarded || request.refused);
}

TEST(PlanInputs, ASticksRestIsAZeroThatWasReceived) {
  PlanInputs inputs = complete();
  inputs.on_user({}, 10.0);
  EXPECT_TRUE(inputs.request(Method::kLeader, kRobot, 10.05).rests);
}

// A stick that is let go seldom meets the centre of both axes at once.
TEST(PlanInputs, AStickThatHardlyTurnsIsAtRestOnlyWhileTheRobotDrives) {
  PlanInputs inputs = complete();
  inputs.on_user({0.0, 0.06}, 10.0);
  RobotState robot = kRobot;
  robot.twist = {0.3, 0.0};
  EXPECT_TRUE(inputs.request(Method::kLeader, robot, 10.05).rests);
  robot.twist = {0.0, 0.06};
  EXPECT_FALSE(inputs.request(Method::kLeader, robot, 10.05).rests);
}

TEST(PlanInputs, AfterTheClockJumpedBackOnlyTheGoalStays) {
  PlanInputs inputs = complete();
  inputs.on_time_jump();
  EXPECT_EQ(inputs.missing(Method::kGoal, 10.0), Reason::kObstaclesSilent);
  inputs.on_obstacles({}, 10.0);
  EXPECT_EQ(inputs.missing(Method::kLeader, 10.0), Reason::kLeaderSilent);
  EXPECT_EQ(inputs.missing(Method::kIntention, 10.0), Reason::kUserSilent);
  ASSERT_FALSE(inputs.missing(Method::kGoal, 10.0));
  const PlanRequest request = inputs.request(Method::kGoal, kRobot, 10.0);
  EXPECT_EQ(request.command, Twist2{});
  EXPECT_FALSE(request.guarded || request.refused);
  EXPECT_EQ(request.X_MG, kGoal);
}

}  // namespace
}  // namespace tandem
