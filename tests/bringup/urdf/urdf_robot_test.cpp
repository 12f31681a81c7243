// SPDX-License-Identifier: Apache-2.0
#include "bringup/urdf/urdf_robot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bringup/urdf/urdf_text.hpp"

namespace tandem {
namespace {

using test::body;
using test::joint;
using test::link;
using test::wheels;

class UrdfRobotTest : public testing::Test {
 protected:
  UrdfRobot read(const std::string& links_and_joints, const UrdfOptions& options = {}) {
    return read_urdf_robot(folder_.robot(links_and_joints), options);
  }
  Footprint outline(const std::string& links_and_joints) {
    return polygon(read(links_and_joints + wheels()).outline);
  }
  // The error without the file's name; empty if there is none.
  std::string error(const std::filesystem::path& file, const UrdfOptions& options = {}) {
    try {
      (void)read_urdf_robot(file, options);
    } catch (const std::exception& error) {
      const std::string text = error.what(), begin = file.string() + ": ";
      EXPECT_TRUE(text.starts_with(begin)) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      return text.substr(begin.size());
    }
    return "";
  }
  std::string error(const std::string& links_and_joints, const UrdfOptions& options = {}) {
    return error(folder_.robot(links_and_joints), options);
  }
  void expect_error(const std::string& part, const std::string& links_and_joints,
                    const UrdfOptions& options = {}) {
    const std::string text = error(links_and_joints, options);
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }

  test::UrdfFolder folder_;
};

void expect_extent(const Footprint& footprint, double front, double rear, double left,
                   double right) {
  const Extent e = extent(footprint);
  EXPECT_NEAR(e.front, front, 1e-4);
  EXPECT_NEAR(e.rear, rear, 1e-4);
  EXPECT_NEAR(e.left, left, 1e-4);
  EXPECT_NEAR(e.right, right, 1e-4);
}

TEST_F(UrdfRobotTest, OutlineOfABox) {
  const UrdfRobot robot = read(body() + wheels());
  EXPECT_EQ(robot.name, "test");
  EXPECT_EQ(robot.outline, (ConvexPolygon{{-0.4, -0.3}, {0.6, -0.3}, {0.6, 0.3}, {-0.4, 0.3}}));
  EXPECT_DOUBLE_EQ(robot.wheel_separation, 0.4);
  ASSERT_TRUE(robot.max_speed);
  EXPECT_DOUBLE_EQ(*robot.max_speed, 10.0 * 0.1);
}

TEST_F(UrdfRobotTest, OutlineOfWheelsIsThatOfTheirBox) {
  expect_extent(outline(link("base_link")), 0.1, 0.1, 0.21, 0.21);
}

TEST_F(UrdfRobotTest, OutlineContainsAllLinksWhereTheirJointsPutThem) {
  // A box of 0.2 m × 0.1 m, turned by 90° on a mast 0.5 m ahead that is turned by 90° itself.
  expect_extent(
      outline(body() + link("mast") + link("box", R"(<box size="0.2 0.1 0.1"/>)") +
              joint("mast_joint", "fixed", "mast", R"(xyz="0.5 0 1" rpy="0 0 1.5707963")") +
              joint("box_joint", "fixed", "box", R"(xyz="0.5 0 0")", "mast")),
      0.6, 0.4, 0.6, 0.3);
}

TEST_F(UrdfRobotTest, OutlineOfATurnedBoxIsItsShadow) {
  // Pitched by 45° about y, a cube of 1 m is √2 m long and 1 m wide.
  expect_extent(outline(link("base_link", R"(<box size="1 1 1"/>)", R"(rpy="0 0.78539816 0")")),
                std::sqrt(0.5), std::sqrt(0.5), 0.5, 0.5);
}

TEST_F(UrdfRobotTest, RoundShapesLieInsideOfTheOutline) {
  for (const char* shape :
       {R"(<cylinder radius="0.5" length="1"/>)", R"(<sphere radius="0.5"/>)"}) {
    const Footprint footprint = outline(link("base_link", shape));
    expect_extent(footprint, 0.5, 0.5, 0.5, 0.5);
    for (double angle = 0.0; angle < 6.3; angle += 0.01) {
      const Eigen::Vector2d direction{std::cos(angle), std::sin(angle)};
      EXPECT_EQ(distance(footprint, 0.4999 * direction), 0.0) << shape << angle;
      EXPECT_GT(distance(footprint, 0.505 * direction), 0.0) << shape << angle;
    }
  }
}

TEST_F(UrdfRobotTest, OutlineIsInTheBaseFrame) {
  const std::string links =
      link("base_footprint") + link("top", R"(<box size="0.4 0.2 1"/>)") +
      joint("top_joint", "fixed", "top", R"(xyz="0.3 0 0")", "base_footprint");
  std::string on_footprint = wheels();
  for (auto at = on_footprint.find("base_link"); at != std::string::npos;
       at = on_footprint.find("base_link"))
    on_footprint.replace(at, 9, "base_footprint");
  expect_extent(polygon(read(links + on_footprint, {.base_frame = "base_footprint"}).outline), 0.5,
                0.1, 0.21, 0.21);
  expect_error("has no link 'base_link'; its links: base_footprint, left, right, top",
               links + on_footprint);
}

TEST_F(UrdfRobotTest, JointsThatMoveTheOutlineAreNamed) {
  const std::string box = R"(<box size="0.1 0.1 0.1"/>)";
  const UrdfRobot robot =
      read(body() + wheels() + link("fork", box) + link("arm", box) +
           joint("caster_swivel", "continuous", "fork", R"(xyz="-0.3 0 0")", "base_link", "0 0 1") +
           joint("shoulder", "revolute", "arm", R"(xyz="0.3 0 0.5")"));
  EXPECT_EQ(robot.moving, (std::vector<std::string>{"caster_swivel", "shoulder"}));
}

TEST_F(UrdfRobotTest, WheelsMayBeNamed) {
  const std::string four = body() + link("a") + link("b") + link("c") + link("d") +
                           joint("fl", "continuous", "a", R"(xyz="0.3 0.25 0")") +
                           joint("rl", "continuous", "b", R"(xyz="-0.3 0.25 0")") +
                           joint("fr", "continuous", "c", R"(xyz="0.3 -0.25 0")") +
                           joint("rr", "continuous", "d", R"(xyz="-0.3 -0.25 0")");
  const UrdfRobot robot = read(four, {.left = {"fl", "rl"}, .right = {"fr", "rr"}});
  EXPECT_DOUBLE_EQ(robot.wheel_separation, 0.5);
  EXPECT_FALSE(robot.max_speed);  // the wheels have no geometry
  expect_error("no continuous joint is called left wheel; there are: [fl, fr, rl, rr]", four);
  expect_error("has no joint 'x'; its joints: fl, fr, rl, rr", four,
               {.left = {"x"}, .right = {"fr"}});
  expect_error("fr is not to the left of fl", four, {.left = {"fr"}, .right = {"fl"}});
  expect_error("the middle of the axle (fl and fr) is at (0.300, 0.000) in base_link", four,
               {.left = {"fl"}, .right = {"fr"}});
}

TEST_F(UrdfRobotTest, WheelsMustBeUnique) {
  expect_error("several joints are called left wheel: Rear_Left_Wheel, left_wheel_joint",
               body() + wheels() + link("rear") +
                   joint("Rear_Left_Wheel", "continuous", "rear", R"(xyz="-0.3 0.2 0")"));
  expect_error("no continuous joint is called left wheel; there are: []", body());
  EXPECT_EQ(error(body() + wheels() + link("caster") +
                  joint("left_caster_wheel", "continuous", "caster", R"(xyz="-0.3 0.2 0")")),
            "");
}

TEST_F(UrdfRobotTest, TheBaseFrameMustBeThatOfADifferentialDrive) {
  expect_error("is at (0.100, 0.000) in base_link", body() + wheels(0.1));
  expect_error(
      "joint 'left_wheel_joint' does not turn about the y axis of base_link",
      body() + link("l") + link("r") +
          joint("left_wheel_joint", "continuous", "l", R"(xyz="0.2 0 0")", "base_link", "1 0 0") +
          joint("right_wheel_joint", "continuous", "r", R"(xyz="-0.2 0 0")", "base_link", "1 0 0"));
}

TEST_F(UrdfRobotTest, SensorsAreFoundByName) {
  const UrdfRobot robot =
      read(body() + wheels() + link("Front_Laser") + link("cam_depth_optical_frame") +
           joint("a", "fixed", "Front_Laser", R"(xyz="0.4 0 0.3" rpy="3.1415927 0 0")") +
           joint("b", "fixed", "cam_depth_optical_frame", R"(xyz="0.3 0 1")"));
  ASSERT_TRUE(robot.scanner.mount && robot.camera.mount);
  EXPECT_EQ(robot.scanner.mount->link, "Front_Laser");
  EXPECT_NEAR(robot.scanner.mount->X_BS.translation().x(), 0.4, 1e-9);
  EXPECT_NEAR(robot.scanner.mount->X_BS.linear()(2, 2), -1.0, 1e-6);  // upside down
  EXPECT_EQ(robot.camera.mount->link, "cam_depth_optical_frame");
}

TEST_F(UrdfRobotTest, SeveralScannersAreNotGuessed) {
  const std::string two = body() + wheels() + link("scan_front") + link("scan_rear") +
                          joint("a", "fixed", "scan_front", R"(xyz="0.4 0 0.3")") +
                          joint("b", "fixed", "scan_rear", R"(xyz="-0.4 0 0.3")");
  const UrdfRobot robot = read(two);
  EXPECT_FALSE(robot.scanner.mount);
  EXPECT_EQ(robot.scanner.candidates, (std::vector<std::string>{"scan_front", "scan_rear"}));
  EXPECT_FALSE(robot.camera.mount);
  EXPECT_TRUE(robot.camera.candidates.empty());
  const UrdfRobot named = read(two, {.scanner = "scan_rear"});
  ASSERT_TRUE(named.scanner.mount);
  EXPECT_NEAR(named.scanner.mount->X_BS.translation().x(), -0.4, 1e-9);
}

TEST_F(UrdfRobotTest, AScannerOnATurretHasNoFixedPlace) {
  const std::string turret = body() + wheels() + link("turret") + link("laser") +
                             joint("pan", "revolute", "turret", R"(xyz="0 0 1")") +
                             joint("mount", "fixed", "laser", R"(xyz="0 0 0.1")", "turret");
  EXPECT_FALSE(read(turret).scanner.mount);
  expect_error("link 'laser' moves against base_link: joint 'pan' is not fixed", turret,
               {.scanner = "laser"});
}

TEST_F(UrdfRobotTest, BrokenFilesAreNamedOnOneLine) {
  EXPECT_NE(error(folder_.path() / "none.urdf").find("cannot be read"), std::string::npos);
  for (const char* content : {"", "no XML", "<robot name=\"a\"><link", "<sdf/>", "<robot/>",
                              "<robot name=\"a\"/>", "<robot name=\"a\"><link/></robot>"})
    EXPECT_TRUE(error(folder_.write("broken.urdf", content)).starts_with("not a valid URDF: "))
        << content << ": " << error(folder_.write("broken.urdf", content));
}

TEST_F(UrdfRobotTest, WhatUrdfdomLeavesOutIsAnError) {
  expect_error("radius [x] is not a valid float", link("base_link", R"(<sphere radius="x"/>)"));
  expect_error("Unknown geometry type 'cone'", link("base_link", "<cone/>"));
  expect_error("not found", body() + joint("a", "fixed", "nowhere", R"(xyz="0 0 0")"));
}

TEST_F(UrdfRobotTest, JointsMustFormATree) {
  expect_error("link 'a' is the child of several joints",
               body() + link("a") + joint("one", "fixed", "a", R"(xyz="0 0 0")") +
                   joint("two", "fixed", "a", R"(xyz="0 0 0")"));
  expect_error("form a loop", body() + link("a") + link("b") +
                                  joint("one", "fixed", "a", R"(xyz="0 0 0")", "b") +
                                  joint("two", "fixed", "b", R"(xyz="0 0 0")", "a"));
}

TEST_F(UrdfRobotTest, XacroMustBeExpanded) {
  const std::string macro = R"(<xacro:include filename="wheels.xacro"/>)";
  expect_error("contains macros of xacro; expand them first", body() + macro);
  expect_error("contains macros of xacro", link("base_link", R"(<sphere radius="${r}"/>)"));
  EXPECT_EQ(error(body() + wheels() + "<!-- " + macro + " -->"), "");
}

TEST_F(UrdfRobotTest, ThereMustBeAnArea) {
  expect_error("no link has a collision geometry",
               link("base_link") + link("l") + link("r") +
                   joint("left_wheel", "continuous", "l", R"(xyz="0 0.2 0")") +
                   joint("right_wheel", "continuous", "r", R"(xyz="0 -0.2 0")"));
}

}  // namespace
}  // namespace tandem
