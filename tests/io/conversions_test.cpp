// SPDX-License-Identifier: Apache-2.0
#include "tandem/io/conversions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "tandem/model/frame_tree.hpp"

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
  q.w(0.0);
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
  geometry_msgs::msg::Transform zero;
  zero.rotation().w(0.0);
  EXPECT_FALSE(from_msg(zero));
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

TEST(Convert, ObstaclesThatAreNotValidAreCountedAndLeftOut) {
  const std::vector<Obstacle> all{{1, {0, 0}, 1.0, 0.5, 0.0},
                                  {5, {0, 0}, 1.0, 0.5, 0.0, {0, 0}, ObstacleShape{2}},
                                  {2, {kNaN, 0}, 1.0, 0.5, 0.0},
                                  {3, {0, 0}, 0.2, 0.5, 0.0},
                                  {4, {0, 0}, 1.0, 0.0, 0.0}};
  const Obstacles back = from_msg(to_msg(all, header({}, "map")));
  ASSERT_EQ(back.all.size(), 1u);
  EXPECT_EQ(back.all[0].id, 1u);
  EXPECT_EQ(back.refused, 4);
}

TEST(Convert, ARectangleStaysOneAndIsABoxInRviz) {
  const std::vector<Obstacle> all{{7, {1, 2}, 1.0, 0.5, 0.3, {0.1, 0.2}, ObstacleShape::kRectangle},
                                  {8, {1, 2}, 1.0, 0.5}};
  const auto msg = to_msg(all, header({}, "map"));
  EXPECT_EQ(msg.obstacles()[0].shape(), tandem_msgs::msg::Obstacle_Constants::RECTANGLE);
  const Obstacles back = from_msg(msg);
  ASSERT_EQ(back.all.size(), 2u);
  EXPECT_EQ(back.all[0].shape, ObstacleShape::kRectangle);
  EXPECT_EQ(back.all[0].v_MO, all[0].v_MO);
  EXPECT_EQ(back.all[1].shape, ObstacleShape::kEllipse);
  const auto markers = to_markers(all, header({}, "map"));
  ASSERT_EQ(markers.markers().size(), 3u);  // the first deletes
  EXPECT_EQ(markers.markers()[1].type(), visualization_msgs::msg::Marker_Constants::CUBE);
  EXPECT_EQ(markers.markers()[1].scale().x(), 2.0);
  EXPECT_EQ(markers.markers()[2].type(), visualization_msgs::msg::Marker_Constants::CYLINDER);
}

TEST(Convert, ATrackedObstacleStaysOne) {
  std::vector<Obstacle> all{{1, {0, 0}, 0.3, 0.3}, {2, {0, 0}, 0.3, 0.3}};
  all[1].tracked = true;
  const Obstacles back = from_msg(to_msg(all, header({}, "map")));
  ASSERT_EQ(back.all.size(), 2u);
  EXPECT_FALSE(back.all[0].tracked);
  EXPECT_TRUE(back.all[1].tracked);
}

nav_msgs::msg::Odometry odometry_of(const Pose2& X, double v, double lateral, double w) {
  nav_msgs::msg::Odometry msg = to_msg(Odometry{X, {v, w}}, header({}, "odom"), "part");
  msg.twist().twist().linear().y(lateral);
  return msg;
}

TEST(Convert, TheTwistOfAnotherPartOfTheRobotIsThatOfTheBaseThere) {
  const auto same = Eigen::Isometry3d::Identity();
  const auto v_at = [&](const Pose2& X_CB) {
    return from_msg(odometry_of({}, 0.5, 0.1, 0.2), same, in_space(X_CB))->twist.v;
  };
  EXPECT_EQ(v_at({}), 0.5);
  EXPECT_DOUBLE_EQ(v_at({0.3, 0.4, 0.0}), 0.5 - 0.2 * 0.4);
  EXPECT_NEAR(v_at({0.3, 0.4, std::numbers::pi}), -v_at({0.3, 0.4, 0.0}), 1e-12);
  EXPECT_NEAR(v_at({0.3, 0.4, std::numbers::pi / 2}), 0.1 + 0.2 * 0.3, 1e-12);
}

TEST(Convert, OdometryInThePlaneIsComposedInThePlane) {
  const Pose2 X_AF{1.0, 2.0, 0.4}, X_FC{-0.5, 0.7, 2.0}, X_CB{0.3, -0.2, -1.0};
  const auto odometry = from_msg(odometry_of(X_FC, 0.5, 0.0, 0.2), in_space(X_AF), in_space(X_CB));
  const Pose2 X_AB = compose(compose(X_AF, X_FC), X_CB);
  EXPECT_NEAR((odometry->X.position() - X_AB.position()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(odometry->X.theta, X_AB.theta, 1e-12);
  EXPECT_NEAR(odometry->twist.w, 0.2, 1e-12);
}

// A camera that looks down by 0.4 rad, on a mast; its optical frame has z ahead and y down. The
// odometry is computed from the base's motion, by central differences.
TEST(Convert, OdometryOfAnOpticalFrameIsThatOfTheBase) {
  const Eigen::Isometry3d X_BC =
      Eigen::Translation3d(0.3, 0.1, 1.2) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX());
  const Twist2 twist{0.6, -0.3};
  const auto X_AC_at = [&](double t) {
    return in_space(integrate(Pose2{2.0, -1.0, 0.8}, twist, t)) * X_BC;
  };
  constexpr double kStep = 1e-4;
  const Eigen::Isometry3d X_AC = X_AC_at(0.0);
  const Eigen::Vector3d v_AC =
      (X_AC_at(kStep).translation() - X_AC_at(-kStep).translation()) / (2.0 * kStep);
  const Eigen::AngleAxisd turn{X_AC_at(-kStep).linear().transpose() * X_AC_at(kStep).linear()};
  const Eigen::Vector3d v = X_AC.linear().transpose() * v_AC,
                        w = turn.axis() * turn.angle() / (2.0 * kStep);
  nav_msgs::msg::Odometry msg;
  const auto place = to_transform(X_AC, header({}, "odom"), "camera").transform();
  msg.pose().pose().position().x(place.translation().x());
  msg.pose().pose().position().y(place.translation().y());
  msg.pose().pose().position().z(place.translation().z());
  msg.pose().pose().orientation(place.rotation());
  for (auto [to, from] : {std::pair{&msg.twist().twist().linear(), &v},
                          std::pair{&msg.twist().twist().angular(), &w}}) {
    to->x(from->x());
    to->y(from->y());
    to->z(from->z());
  }
  const auto odometry = from_msg(msg, Eigen::Isometry3d::Identity(), X_BC.inverse());
  EXPECT_NEAR((odometry->X.position() - Eigen::Vector2d(2.0, -1.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(odometry->X.theta, 0.8, 1e-9);
  EXPECT_NEAR(odometry->twist.v, twist.v, 1e-6);
  EXPECT_NEAR(odometry->twist.w, twist.w, 1e-6);
}

// base_link leans above base_footprint: its odometry shows the lean, that of the wheels does not.
TEST(Convert, ALeaningBodyDoesNotShiftTheRobot) {
  const Eigen::Isometry3d lean =
      Eigen::Translation3d(0.0, 0.0, 0.4) * Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY());
  const auto below =
      from_msg(odometry_of({1.0, 2.0, 0.5}, 0.6, 0.0, 0.3), Eigen::Isometry3d::Identity(), lean);
  EXPECT_NEAR((below->X.position() - Eigen::Vector2d(1.0, 2.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(below->twist.v, 0.6, 1e-12);
  nav_msgs::msg::Odometry leaning = odometry_of({1.0, 2.0, 0.0}, 0.6, 0.0, 0.0);
  leaning.pose().pose().position().z(0.4);
  leaning.pose().pose().orientation().y(std::sin(0.1));
  leaning.pose().pose().orientation().w(std::cos(0.1));
  const auto of_base = from_msg(leaning, Eigen::Isometry3d::Identity(), lean.inverse());
  EXPECT_NEAR((of_base->X.position() - Eigen::Vector2d(1.0, 2.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(of_base->twist.v, 0.6 * std::cos(0.2), 1e-12);
}

TEST(Convert, NumbersThatOdometryDoesNotNeedMayBeMissing) {
  nav_msgs::msg::Odometry msg = odometry_of({1.0, 2.0, 0.0}, 0.6, 0.0, 0.3);
  msg.pose().pose().position().z(kNaN);
  msg.twist().twist().linear().z(kNaN);
  const auto moved = from_msg(msg, in_space({1.0, 0.0, 0.0}), in_space({0.2, 0.0, 0.0}));
  EXPECT_NEAR(moved->X.x, 2.2, 1e-12);
  EXPECT_NEAR(moved->twist.v, 0.6, 1e-12);
  msg.twist().twist().linear().x(kNaN);
  EXPECT_FALSE(from_msg(msg, in_space({1.0, 0.0, 0.0}), in_space({0.2, 0.0, 0.0})));
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
