// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/robot_command.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "bringup/urdf/urdf_text.hpp"
#include "support/paths.hpp"
#include "tandem/config/yaml_document.hpp"
#include "tandem/octomap_builder/mounting.hpp"

namespace tandem {
namespace {

using test::joint;
using test::link;

class RobotCommand : public testing::Test {
 protected:
  // What `tandem robot` prints, or the error.
  static std::string run(std::vector<std::string> words) {
    CLI::App program{"tandem"};
    add_robot_command(program);
    words.insert(words.begin(), "robot");
    std::reverse(words.begin(), words.end());  // as CLI11 wants them
    testing::internal::CaptureStdout();
    try {
      program.parse(words);
    } catch (const std::exception& error) {
      return testing::internal::GetCapturedStdout() + error.what();
    }
    return testing::internal::GetCapturedStdout();
  }
  std::string printed(const std::string& links_and_joints, std::vector<std::string> options = {}) {
    options.insert(options.begin(), folder_.robot(links_and_joints));
    return run(options);
  }
  static YAML::Node parameters(const std::string& text) {
    return parse_document(text)["/**"]["ros__parameters"];
  }
  // What the comment about sensors contains.
  static YAML::Node sensors(const std::string& text) {
    const auto begin = text.find("# octomap_builder:");
    if (begin == std::string::npos) return {};
    std::string yaml = text.substr(begin);
    for (auto at = yaml.find("# "); at != std::string::npos; at = yaml.find("\n# "))
      yaml.erase(at == 0 ? 0 : at + 1, 2);
    return parse_document(yaml)["octomap_builder"]["ros__parameters"];
  }

  test::UrdfFolder folder_;
};

TEST_F(RobotCommand, MakesTheTrolleysFileOfItsUrdf) {
  const std::string text = run({test::source_path("tests/example_robot/trolley.urdf")});
  const YAML::Node made = parameters(text);
  const YAML::Node written = load_document(
      test::source_path("tests/example_robot/trolley.yaml"))["/**"]["ros__parameters"];
  EXPECT_EQ(made.size(), 3U) << text;
  EXPECT_EQ(made["footprint"].as<std::vector<double>>(),
            written["footprint"].as<std::vector<double>>())
      << text;
  EXPECT_EQ(made["wheel_separation"].as<double>(), written["wheel_separation"].as<double>());
  EXPECT_EQ(made["v_max"].as<double>(), 0.7) << "the wheels are slower than the default";
  EXPECT_NE(text.find("velocity limits allow 0.7 m/s"), std::string::npos) << text;
  EXPECT_NE(text.find("    # a_brake: 1.5  # [m/s²] "), std::string::npos) << text;
  EXPECT_FALSE(parse_document(text)["octomap_builder"]) << text;  // only a comment
  const auto scan_pose = sensors(text)["scan_pose"].as<std::vector<double>>();
  EXPECT_EQ(scan_pose, (std::vector<double>{0.3, 0.0, 0.55, 0.0, 0.0, 0.0})) << text;
}

TEST_F(RobotCommand, PrintsARectangleAsOne) {
  const std::string text = printed(test::body() + test::wheels());
  const YAML::Node made = parameters(text);
  EXPECT_EQ(made.size(), 4U) << text;
  EXPECT_EQ(made["length"].as<double>(), 1.0) << text;
  EXPECT_EQ(made["width"].as<double>(), 0.6) << text;
  EXPECT_EQ(made["center_x"].as<double>(), 0.1) << text;
  EXPECT_EQ(made["wheel_separation"].as<double>(), 0.4) << text;
  EXPECT_EQ(text.find("octomap_builder"), std::string::npos) << text;
}

TEST_F(RobotCommand, PrintsARectangleBesideTheAxisAsAPolygon) {
  const std::string text = printed(
      link("base_link", R"(<box size="1 0.6 0.3"/>)", R"(xyz="0 0.05 0")") + test::wheels());
  EXPECT_EQ(parameters(text)["footprint"].as<std::vector<double>>(),
            (std::vector<double>{-0.5, -0.25, 0.5, -0.25, 0.5, 0.35, -0.5, 0.35}))
      << text;
}

TEST_F(RobotCommand, PrintsMountsAsTheMapBuilderReadsThem) {
  const std::string text =
      printed(test::body() + test::wheels() + link("laser") +
              joint("a", "fixed", "laser", R"(xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 2.6")"));
  const auto numbers = sensors(text)["scan_pose"].as<std::vector<double>>();
  EXPECT_EQ(numbers, (std::vector<double>{0.1, -0.2, 0.3, 0.4, -0.5, 2.6})) << text;
  const Eigen::Isometry3d X_BS = mounting("scan_pose", numbers).value();
  const Eigen::Matrix3d in_urdf = (Eigen::AngleAxisd(2.6, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(-0.5, Eigen::Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()))
                                      .toRotationMatrix();
  EXPECT_TRUE(X_BS.linear().isApprox(in_urdf, 1e-9));
}

TEST_F(RobotCommand, NamesTheLinksThatMayBeTheScanner) {
  const std::string two = test::body() + test::wheels() + link("scan_1") + link("scan_2") +
                          joint("a", "fixed", "scan_1", R"(xyz="0.4 0 0.3")") +
                          joint("b", "fixed", "scan_2", R"(xyz="-0.4 0 0.3")");
  const std::string text = printed(two);
  EXPECT_NE(text.find("name one with --scanner: scan_1, scan_2"), std::string::npos) << text;
  EXPECT_TRUE(sensors(printed(two, {"--scanner", "scan_2"}))["scan_pose"]);
}

TEST_F(RobotCommand, WheelsAreGivenBySide) {
  const std::string four = test::body() + link("a") + link("b") + link("c") + link("d") +
                           joint("fl", "continuous", "a", R"(xyz="0.3 0.25 0")") +
                           joint("rl", "continuous", "b", R"(xyz="-0.3 0.25 0")") +
                           joint("fr", "continuous", "c", R"(xyz="0.3 -0.25 0")") +
                           joint("rr", "continuous", "d", R"(xyz="-0.3 -0.25 0")");
  const std::string text = printed(four, {"--left", "fl", "rl", "--right", "fr", "rr"});
  EXPECT_EQ(parameters(text)["wheel_separation"].as<double>(-1.0), 0.5) << text;
}

TEST_F(RobotCommand, RefusesWhatANodeWouldRefuse) {
  const std::string far =
      printed(link("base_link", R"(<box size="0.1 0.1 0.1"/>)", R"(xyz="0 0 1")") +
              link("trailer", R"(<box size="1 1 1"/>)") + test::wheels() +
              joint("hitch", "fixed", "trailer", R"(xyz="-20 0 0")"));
  EXPECT_NE(far.find("robot.urdf: footprint = -20.5 outside [-5, 5]"), std::string::npos) << far;
}

}  // namespace
}  // namespace tandem
