// SPDX-License-Identifier: Apache-2.0
// Tests that a remapping rule which renames nothing is reported, and no other.
#include "bringup/system/unused_remappings.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

using Lines = std::vector<std::string>;

SystemNode node(const std::string& component, std::map<std::string, std::string> remappings) {
  SystemNode result{component, {}};
  result.options.name = component;
  result.options.remappings = std::move(remappings);
  return result;
}

Lines complaints(const std::vector<SystemNode>& nodes, const std::vector<std::string>& rules = {}) {
  std::vector<std::string> arguments{"--ros-args"};
  for (const auto& rule : rules) arguments.insert(arguments.end(), {"-r", rule});
  return unused_remappings({"robot.yaml", nodes}, rt::parse_ros_arguments(arguments));
}

TEST(UnusedRemappings, OfASystemFileNameTheNearestName) {
  EXPECT_EQ(complaints({node("octomap_builder", {{"scn", "/front/scan"}}), node("teleop", {})}),
            Lines{"robot.yaml: octomap_builder: remapping `scn` has no effect: octomap_builder has "
                  "no topic, service or action of that name; did you mean `scan`?"});
}

TEST(UnusedRemappings, OfTheCommandLineAreReportedIfNoNodeHasTheName) {
  const std::vector<SystemNode> nodes{node("octomap_builder", {}), node("teleop", {})};
  EXPECT_EQ(complaints(nodes, {"odm:=/base/odom"}),
            Lines{"--ros-args -r odm:=/base/odom: remapping `odm` has no effect: no node has a "
                  "topic, service or action of that name; did you mean `odom`?"});
  EXPECT_EQ(complaints(nodes, {"teleop:scan:=/front/scan"}).size(), 1U) << "teleop reads no scan";
}

TEST(UnusedRemappings, AreNoneWhereEachRuleRenamesSomething) {
  const std::vector<SystemNode> nodes{
      node("octomap_builder", {{"scan", "/front/scan"}, {"cloud_in", "/camera/points"}}),
      node("diff_drive_sim", {{"~/reset", "/again"}}), node("teleop", {})};
  EXPECT_EQ(complaints(nodes, {"odom:=/base/odom", "/tf:=tf", "/clock:=clock", "__ns:=/r1",
                               "teleop:joy:=/pad", "teleop:__node:=stick"}),
            Lines{});
}

TEST(UnusedRemappings, AreUnknownOfANodeThatOpensAnyTopic) {
  EXPECT_EQ(complaints({node("dashboard", {{"anything", "/else"}})}), Lines{});
}

}  // namespace
}  // namespace tandem
