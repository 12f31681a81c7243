// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/urdf.hpp"

#include <gtest/gtest.h>

#include <string>

namespace tandem {
namespace {

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

bool has(const std::string& text, const std::string& part) { return count(text, part) == 1; }

TEST(Urdf, ShowsARectangleAndTwoWheels) {
  RobotParams robot;
  robot.length = 0.8;
  robot.width = 0.5;
  robot.center_x = 0.1;
  robot.wheel_separation = 0.4;
  const std::string urdf = urdf_of(robot, "base_link");
  EXPECT_TRUE(urdf.starts_with("<?xml"));
  EXPECT_TRUE(has(urdf, "<link name=\"base_link\">"));
  EXPECT_TRUE(has(urdf, "<box size=\"0.8 0.5 0.2\"/>"));
  EXPECT_TRUE(has(urdf, "xyz=\"0.1 0 0.15\""));
  EXPECT_EQ(count(urdf, "<cylinder "), 2);
  EXPECT_TRUE(has(urdf, "xyz=\"0 0.2 0.1\""));
  EXPECT_TRUE(has(urdf, "xyz=\"0 -0.2 0.1\""));
  EXPECT_EQ(count(urdf, "<visual>"), count(urdf, "</visual>"));
}

TEST(Urdf, ShowsTheEdgesOfPolygons) {
  RobotParams robot;
  robot.footprint = {0.5, -0.25, 0.5, 0.25, -0.5, 0.25, -0.5, -0.25};
  const std::string urdf = urdf_of(robot, "base_link");
  EXPECT_EQ(count(urdf, "<box size=\"0.5 0.02 0.2\"/>"), 2);
  EXPECT_EQ(count(urdf, "<box size=\"1 0.02 0.2\"/>"), 2);
  EXPECT_TRUE(has(urdf, "xyz=\"0.5 0 0.15\" rpy=\"0 0 1.5708\""));
}

TEST(Urdf, EscapesTheFramesName) {
  EXPECT_TRUE(has(urdf_of({}, "a\"b<c&d"), "<link name=\"a&quot;b&lt;c&amp;d\">"));
}

TEST(Urdf, RefusesAFootprintThatIsNone) {
  RobotParams robot;
  robot.footprint = {0.5, -0.25, 0.5};
  EXPECT_THROW((void)urdf_of(robot, "base_link"), std::invalid_argument);
}

}  // namespace
}  // namespace tandem
