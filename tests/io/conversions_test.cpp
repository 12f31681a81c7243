// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/conversions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace tandem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Convert, TwistReadsForwardAndYawOnlyAndRefusesNaN) {
  geometry_msgs::msg::Twist msg;
  msg.linear().x(0.4);
  msg.linear().y(kNaN);  // not read: a differential drive has no sideways
  msg.angular().z(-0.3);
  EXPECT_EQ(from_msg(msg), (Twist2{0.4, -0.3}));
  msg.angular().z(kNaN);
  EXPECT_FALSE(from_msg(msg));
}

TEST(Convert, PoseComesBackWithItsHeading) {
  for (double theta = -3.1; theta < 3.2; theta += 0.1) {
    const auto back = from_msg(to_msg(Pose2{1.0, -2.0, theta}));
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->x, 1.0, 1e-12);
    EXPECT_NEAR(wrap_angle(back->theta - theta), 0.0, 1e-12);
  }
}

TEST(Convert, DistinguishesAZeroQuaternionFromANonFiniteNumber) {
  geometry_msgs::msg::Quaternion q;
  EXPECT_NE(std::string{fault_of(q)}.find("zero quaternion"), std::string::npos);
  q.w(kNaN);
  EXPECT_STREQ(fault_of(q), "is not finite");
}

TEST(Convert, ATransformInSpaceRoundTripsAndAnInvalidOneIsRefused) {
  const Eigen::Isometry3d X = Eigen::Translation3d(1.0, -2.0, 0.5) *
                              Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, 2.0, -1.0).normalized());
  auto msg = to_transform(X, header({}, "base_link"), "laser").transform();
  EXPECT_TRUE(from_msg(msg)->isApprox(X, 1e-12));
  msg.translation().z(kNaN);
  EXPECT_FALSE(from_msg(msg));
  EXPECT_FALSE(from_msg(geometry_msgs::msg::Transform{}));  // its quaternion is zero
  msg = to_transform(X, header({}, "base_link"), "laser").transform();
  msg.rotation().w(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(from_msg(msg));
}

TEST(Convert, HeadingIsTheYawOfATiltedPose) {
  geometry_msgs::msg::Pose msg;  // yaw π/2 after a roll of π
  msg.orientation().x(std::numbers::sqrt2 / 2);
  msg.orientation().y(std::numbers::sqrt2 / 2);
  msg.orientation().z(0.0);
  msg.orientation().w(0.0);
  EXPECT_NEAR(from_msg(msg)->theta, std::numbers::pi / 2, 1e-9);
}

TEST(Convert, PoseRefusesNaNAndAZeroQuaternion) {
  geometry_msgs::msg::Pose msg = to_msg(Pose2{});
  msg.orientation().w(0.0);
  EXPECT_FALSE(from_msg(msg));
  msg = to_msg(Pose2{});
  msg.position().x(kNaN);
  EXPECT_FALSE(from_msg(msg));
  msg = to_msg(Pose2{});
  msg.orientation().z(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(from_msg(msg));
}

TEST(Convert, ObstaclesThatAreNoEllipsesAreCountedAndLeftOut) {
  const std::vector<Obstacle> all{{1, {0, 0}, 1.0, 0.5, 0.0},
                                  {2, {kNaN, 0}, 1.0, 0.5, 0.0},
                                  {3, {0, 0}, 0.2, 0.5, 0.0},
                                  {4, {0, 0}, 1.0, 0.0, 0.0}};
  const Obstacles back = from_msg(to_msg(all, header({}, "map")));
  ASSERT_EQ(back.all.size(), 1u);
  EXPECT_EQ(back.all[0].id, 1u);
  EXPECT_EQ(back.refused, 3);
}

TEST(Convert, TheTwistOfAnotherPartOfTheRobotIsThatOfTheBaseThere) {
  geometry_msgs::msg::Twist of_C;
  of_C.linear().x(0.5);
  of_C.linear().y(0.1);
  of_C.angular().z(0.2);
  EXPECT_EQ(twist_of({}, of_C), (Twist2{0.5, 0.2}));
  const Twist2 beside = twist_of({0.3, 0.4, 0.0}, of_C);
  EXPECT_DOUBLE_EQ(beside.v, 0.5 - 0.2 * 0.4);
  EXPECT_DOUBLE_EQ(beside.w, 0.2);
  EXPECT_NEAR(twist_of({0.3, 0.4, std::numbers::pi}, of_C).v, -beside.v, 1e-12);
  EXPECT_NEAR(twist_of({0.3, 0.4, std::numbers::pi / 2}, of_C).v, 0.1 + 0.2 * 0.3, 1e-12);
}

TEST(Convert, GroundTruthIsOfTheMapOrOfNoFrame) {
  for (const char* frame : {"map", "/map", ""})
    EXPECT_TRUE(truth_from(to_msg(Odometry{}, header({}, frame), "base_link"), "map")) << frame;
  EXPECT_FALSE(truth_from(to_msg(Odometry{}, header({}, "odom"), "base_link"), "map"));
}

TEST(Convert, FindsTheTransformAmongOthers) {
  tf2_msgs::msg::TFMessage msg;
  msg.transforms().push_back(to_transform(Pose2{9, 9, 0}, header({}, "odom"), "base_link"));
  msg.transforms().push_back(to_transform(Pose2{1, 2, 0.5}, header({}, "map"), "odom"));
  const auto X_MW = find_transform(msg, "map", "odom");
  ASSERT_TRUE(X_MW);
  EXPECT_NEAR(X_MW->theta, 0.5, 1e-12);
  EXPECT_FALSE(find_transform(msg, "map", "base_link"));
}

TEST(Convert, AnOccupancyGridGivesBackTheGrid) {
  const Grid grid{
      0.5, {-1.0, 2.0}, 2, 2, {Cell::kOccupied, Cell::kFree, Cell::kUnknown, Cell::kFree}};
  auto msg = to_msg(grid, {});
  const Grid back = to_grid(from_msg(msg));
  EXPECT_EQ(back.cells, grid.cells);
  EXPECT_EQ(back.origin, grid.origin);
  EXPECT_EQ(back.width, 2);
  msg.info().origin().orientation().w(0.0);
  EXPECT_NE(error_of(from_msg(msg)).find("zero quaternion"), std::string::npos);
}

TEST(Convert, GridBecomesAnOccupancyGridAsRvizReadsIt) {
  const Grid grid{0.1, {-1.0, 2.0}, 3, 1, {Cell::kFree, Cell::kOccupied, Cell::kUnknown}};
  const auto msg = to_msg(grid, header({}, "map"));
  EXPECT_EQ(msg.data(), (std::vector<std::int8_t>{0, 100, -1}));
  EXPECT_EQ(msg.info().width(), 3u);
  EXPECT_NEAR(msg.info().origin().position().y(), 2.0, 1e-12);
}

}  // namespace
}  // namespace tandem
