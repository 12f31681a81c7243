// SPDX-License-Identifier: Apache-2.0
// Tests the guesses that pass what blocks the nominal trajectory, or stop before it.
#include "tandem/local_planner/guesses.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tandem/model/diff_drive.hpp"

namespace tandem {
namespace {

constexpr double kRadius = 0.3;  // [m] of the robot, one disc
constexpr PairLimits kLimits{.margin = 0.05, .dt = 0.25};
const RobotParams kRobotParams{};

Body disc() { return {{}, {{{0.0, 0.0}, kRadius}}, true}; }

// Straight ahead from the origin at this speed.
Forecast straight(double v, std::size_t stages = 12) {
  Forecast motion{std::vector<Twist2>(stages, Twist2{v, 0.0}), {Pose2{}}};
  for (const Twist2& twist : motion.twist)
    motion.X_MB.push_back(integrate(motion.X_MB.back(), twist, kLimits.dt));
  return motion;
}

Obstacle pillar(double x, double y = 0.0) { return {.p_MO = {x, y}, .a = 0.2, .b = 0.2}; }

TEST(PointsBeside, AreNoneIfNothingBlocks) {
  EXPECT_TRUE(points_beside(straight(0.8), disc(), std::vector{pillar(1.0, 2.0)}, kLimits).empty());
}

TEST(PointsBeside, LieLeftAndRightOfAPoleAndClearOfIt) {
  const std::vector obstacles{pillar(1.5)};
  const auto points = points_beside(straight(0.8), disc(), obstacles, kLimits);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_GT(points[0].y(), 0.0);
  EXPECT_LT(points[1].y(), 0.0);
  for (const auto& p : points) {
    const double gap = (p - obstacles[0].p_MO).norm() - obstacles[0].a - kRadius;
    EXPECT_GE(gap, kLimits.margin);
    EXPECT_LE(gap, kLimits.margin + 0.2) << "no farther than needed";
  }
}

TEST(PointsBeside, LeaveOutASideWithoutRoom) {
  const Obstacle wall{
      .p_MO = {1.5, 2.2}, .a = 2.4, .b = 0.2, .angle = 0.5 * std::numbers::pi};  // y −0.2 … 4.6
  const auto points = points_beside(straight(0.8), disc(), std::vector{wall}, kLimits);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_LT(points[0].y(), 0.0);
}

TEST(PointsBeside, AreClearOfAMovingObstacleWhenTheRobotGetsThere) {
  Obstacle person = pillar(1.5, -1.2);
  person.v_MO = {0.0, 0.8};  // in the robot's path 1.5 s later
  const auto points = points_beside(straight(0.8), disc(), std::vector{person}, kLimits);
  ASSERT_FALSE(points.empty());
  for (const auto& p : points) EXPECT_GT((p - Eigen::Vector2d(1.5, 0.0)).norm(), kRadius);
}

TEST(StoppedInTime, AClearMotionIsUnchanged) {
  const Forecast motion = straight(0.8);
  const Forecast out =
      stopped_in_time(motion, disc(), std::vector{pillar(1.0, 2.0)}, kLimits, kRobotParams);
  EXPECT_EQ(out.twist, motion.twist);
}

TEST(StoppedInTime, EndsBeforeTheObstacleAndBrakesNoHarderThanTheRobotCan) {
  const std::vector obstacles{pillar(1.7)};
  const Forecast motion = straight(0.6);
  const Forecast out = stopped_in_time(motion, disc(), obstacles, kLimits, kRobotParams);
  const auto ends = std::span(out.X_MB).subspan(1);
  EXPECT_EQ(first_miss(disc(), obstacles, ends, kLimits), ends.size());
  EXPECT_EQ(out.twist.front(), motion.twist.front());
  EXPECT_EQ(out.twist.back(), Twist2{});
  for (std::size_t k = 1; k < out.twist.size(); ++k)
    EXPECT_LE(out.twist[k - 1].v - out.twist[k].v, kRobotParams.a_max * kLimits.dt + 1e-12) << k;
}

TEST(StoppedInTime, BrakesAfterTheFirstTwistIfItIsTooLate) {
  const Forecast motion = straight(0.8);
  const Forecast out =
      stopped_in_time(motion, disc(), std::vector{pillar(0.7)}, kLimits, kRobotParams);
  EXPECT_EQ(out.twist[0], motion.twist[0]);
  EXPECT_NEAR(out.twist[1].v, 0.8 - kRobotParams.a_max * kLimits.dt, 1e-12);
}

TEST(IsStuck, StandingIsStuckAndTheNominalTrajectoryIsNot) {
  const Forecast nominal = straight(0.5);
  const auto stuck = [&](const Forecast& motion) {
    return is_stuck(Method::kIntention, nominal, {0.0, 0.0}, motion, 3.0, kRobotParams);
  };
  EXPECT_TRUE(stuck(straight(0.0)));
  EXPECT_FALSE(stuck(nominal));
}

TEST(IsStuck, WhereThePersonHardlyMovesNothingIsStuck) {
  EXPECT_FALSE(
      is_stuck(Method::kIntention, straight(0.05), {0.0, 0.0}, straight(0.0), 3.0, kRobotParams));
}

TEST(IsStuck, TowardATargetPartOfTheRobotsSpeedIsEnough) {
  const auto stuck = [](double target, double speed) {
    return is_stuck(Method::kLeader, straight(0.8), {target, 0.0}, straight(speed), 3.0,
                    kRobotParams);
  };
  EXPECT_TRUE(stuck(5.0, 0.1));
  EXPECT_FALSE(stuck(5.0, 0.2));
  EXPECT_FALSE(stuck(0.2, 0.0)) << "it is there";
}

// --- guesses that need no solve of their own ---

bool alike(const Forecast& guess, const Forecast& motion, const std::vector<Obstacle>& obstacles) {
  return is_alike(guess, motion, disc(), obstacles, kLimits);
}

TEST(IsAlike, MotionsWithNothingBetweenThem) {
  EXPECT_TRUE(alike(straight(0.8), straight(0.6), {}));
  EXPECT_TRUE(alike(straight(0.8), straight(0.6), {pillar(8.0)}));
}

TEST(IsAlike, NotIfAnObstacleLiesBetween) {
  Forecast left = straight(0.8), right = straight(0.8);
  for (std::size_t k = 1; k < left.X_MB.size(); ++k) {
    left.X_MB[k].y += 1.0;
    right.X_MB[k].y -= 1.0;
  }
  const double there = left.X_MB[left.X_MB.size() / 2].x;
  EXPECT_TRUE(alike(left, right, {}));
  EXPECT_FALSE(alike(left, right, {pillar(there)}));
}

TEST(IsAlike, NotForwardAndBackward) { EXPECT_FALSE(alike(straight(0.5), straight(-0.2), {})); }

TEST(IsAlike, NotIfOneTurnsAway) {
  Forecast turned = straight(0.5);
  for (Pose2& X_MB : turned.X_MB) X_MB.theta += 1.5;
  EXPECT_FALSE(alike(straight(0.5), turned, {}));
}

}  // namespace
}  // namespace tandem
