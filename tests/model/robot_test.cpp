// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/robot.hpp"

#include <gtest/gtest.h>

#include "tandem/model/diff_drive.hpp"
#include "tandem/model/localization.hpp"

namespace tandem {
namespace {

TEST(DiffDrive, WheelsAndBodyAreInverseMaps) {
  const Twist2 twist{0.7, -0.9};
  const WheelSpeeds wheels = to_wheels(twist, 0.445);
  EXPECT_GT(wheels.left, wheels.right);  // turns right
  EXPECT_NEAR(to_body(wheels, 0.445).v, twist.v, 1e-15);
  EXPECT_NEAR(to_body(wheels, 0.445).w, twist.w, 1e-15);
}

TEST(DiffDrive, LimitKeepsTheArc) {
  const RobotParams robot;
  for (const Twist2 twist : {Twist2{2.0, 0.5}, Twist2{-1.0, 0.5}, Twist2{0.5, -3.0}}) {
    const Twist2 limited = limit(twist, robot);
    EXPECT_LE(limited.v, robot.v_max + 1e-12);
    EXPECT_GE(limited.v, robot.v_min - 1e-12);
    EXPECT_LE(std::abs(limited.w), robot.w_max + 1e-12);
    EXPECT_NEAR(limited.v * twist.w, limited.w * twist.v, 1e-12);
    EXPECT_LT(std::abs(limited.v), std::abs(twist.v));
  }
  EXPECT_EQ(limit({0.3, -0.2}, robot), (Twist2{0.3, -0.2}));
}

TEST(DiffDrive, ApproachNeverOvershoots) {
  EXPECT_EQ(approach(0.0, 1.0, 0.3), 0.3);
  EXPECT_EQ(approach(0.9, 1.0, 0.3), 1.0);
  EXPECT_EQ(approach(0.0, -1.0, 0.3), -0.3);
}

TEST(RobotParams, DescribesARectangleOrAPolygon) {
  RobotParams robot;
  EXPECT_EQ(footprint_of(robot).parts.front().size(), 4u);
  robot.footprint = {-0.3, -0.3, 0.5, 0.0, -0.3, 0.3};
  EXPECT_EQ(footprint_of(robot).parts.front().size(), 3u);
  robot.footprint.push_back(1.0);
  EXPECT_THROW((void)footprint_of(robot), std::invalid_argument);
}

// A body and a foot plate in front of it.
RobotParams two_parts() {
  RobotParams robot;
  robot.footprint = {-0.5, -0.3, 0.4, -0.3, 0.4, 0.3, -0.5, 0.3, 0.3, -0.2, 0.7, 0.0, 0.3, 0.2};
  robot.footprint_parts = {4, 3};
  return robot;
}

TEST(RobotParams, DescribesAnOutlineOfSeveralParts) {
  const RobotParams robot = two_parts();
  EXPECT_NO_THROW(check(robot));
  const Footprint footprint = footprint_of(robot);
  ASSERT_EQ(footprint.parts.size(), 2u);
  EXPECT_EQ(footprint.parts[0].size(), 4u);
  ASSERT_EQ(footprint.parts[1].size(), 3u);
  EXPECT_EQ(footprint.parts[1][1], Eigen::Vector2d(0.7, 0.0));
}

std::string complaint_about(const RobotParams& robot) {
  try {
    check(robot);
    (void)footprint_of(robot);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(RobotParams, RefusesCountsThatDoNotFitTheVertices) {
  const auto of_counts = [](std::vector<double> counts) {
    RobotParams robot = two_parts();
    robot.footprint_parts = std::move(counts);
    return complaint_about(robot);
  };
  EXPECT_EQ(of_counts({4, 4}),
            "footprint_parts: the parts have 8 vertices in all, but footprint gives 7");
  EXPECT_NE(of_counts({5, 2}).find("footprint_parts = 2 outside [3, 100]"), std::string::npos);
  EXPECT_EQ(of_counts({3.5, 3.5}),
            "footprint_parts: number 1 must be a whole number of vertices, at least 3");
  EXPECT_NE(of_counts({7}).find("part 1, vertex 4"), std::string::npos);
}

TEST(RobotParams, RefusesPartsWithoutVertices) {
  RobotParams robot;
  robot.footprint_parts = {4};
  EXPECT_EQ(complaint_about(robot),
            "footprint_parts: the parts have 4 vertices in all, but footprint gives 0");
}

TEST(RobotParams, RejectsNonFiniteNumbers) {
  RobotParams robot;
  EXPECT_NO_THROW(check(robot));
  robot.v_max = std::nan("");
  EXPECT_THROW(check(robot), std::invalid_argument);
}

TEST(Localization, ComposesTransformAndOdometry) {
  Localization localization({});
  EXPECT_FALSE(localization.state(0.0));
  localization.on_odom({1.0, 0.0, 0.0}, {0.5, 0.1}, 0.0);
  EXPECT_FALSE(localization.state(0.0));  // no transform
  localization.on_transform({2.0, 3.0, 0.5 * std::numbers::pi}, 0.0);
  const auto state = localization.state(0.1);
  ASSERT_TRUE(state);
  EXPECT_NEAR(state->X_MB.x, 2.0, 1e-12);
  EXPECT_NEAR(state->X_MB.y, 4.0, 1e-12);
  EXPECT_EQ(state->twist, (Twist2{0.5, 0.1}));
  EXPECT_EQ(state->t, 0.0);
}

TEST(Localization, KnowsNothingOnceAPartIsTooOld) {
  Localization localization({});
  localization.on_transform({}, 0.0);
  localization.on_odom({}, {}, 0.0);
  EXPECT_TRUE(localization.state(0.15));
  EXPECT_FALSE(localization.state(0.16));
  localization.on_odom({}, {}, 1.2);
  EXPECT_FALSE(localization.state(1.2));
  localization.on_transform({}, 1.2);
  EXPECT_TRUE(localization.state(1.2));
}

TEST(Localization, WhatCameLateHoldsForEarlierAndOvertakesNothing) {
  Localization localization({.map_is_odom = true});
  localization.on_odom({1.0, 0.0, 0.0}, {}, 2.0, 0.1);
  ASSERT_TRUE(localization.state(2.0));
  EXPECT_NEAR(localization.state(2.0)->t, 1.9, 1e-12);
  EXPECT_FALSE(localization.state(2.06));
  localization.on_odom({2.0, 0.0, 0.0}, {}, 2.02, 0.0);
  localization.on_odom({1.5, 0.0, 0.0}, {}, 2.04, 0.08);
  EXPECT_EQ(localization.state(2.04)->X_MB.x, 2.0);
  localization.on_odom({3.0, 0.0, 0.0}, {}, 3.0, 0.5);  // treated as missing
  EXPECT_FALSE(localization.state(3.0));
}

TEST(Localization, ForgetsEverythingFromBeforeAClockReset) {
  Localization localization({});
  localization.on_transform({}, 5.0);
  localization.on_odom({}, {}, 5.0);
  localization.on_time_jump();
  EXPECT_FALSE(localization.state(0.0));
  localization.on_odom({}, {}, 0.0);
  EXPECT_FALSE(localization.state(0.0));
  EXPECT_FALSE(localization.state(5.0));
  localization.on_transform({}, 5.0);
  localization.on_odom({}, {}, 5.0);
  EXPECT_TRUE(localization.state(5.0));
}

TEST(Localization, NeedsNoTransformIfTheFramesAreOne) {
  Localization localization({.map_is_odom = true});
  localization.on_odom({1.0, 2.0, 0.3}, {}, 0.0);
  ASSERT_TRUE(localization.state(0.0));
  EXPECT_EQ(localization.state(0.0)->X_MB.y, 2.0);
}

TEST(Localization, IgnoresNonFiniteInputs) {
  Localization localization({.map_is_odom = true});
  localization.on_odom({std::nan(""), 0.0, 0.0}, {}, 0.0);
  EXPECT_FALSE(localization.state(0.0));
}

}  // namespace
}  // namespace tandem
