// SPDX-License-Identifier: Apache-2.0
#include "octomap_builder/frame_tree.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace tandem {
namespace {

Eigen::Isometry3d at(double x, double y, double z, double yaw = 0.0) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

TEST(FrameTree, FollowsLinksUpAndDown) {
  FrameTree tree;
  tree.set("base_link", "mast", at(-0.2, 0.0, 1.0, std::numbers::pi / 2));
  tree.set("mast", "laser", at(0.1, 0.0, 0.05));
  tree.set("base_footprint", "base_link", at(0.0, 0.0, 0.15));
  EXPECT_TRUE(tree.pose("base_link", "base_link")->isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(tree.pose("base_link", "laser")->isApprox(at(-0.2, 0.1, 1.05, std::numbers::pi / 2)));
  EXPECT_TRUE(
      tree.pose("base_footprint", "laser")->isApprox(at(-0.2, 0.1, 1.2, std::numbers::pi / 2)));
  EXPECT_TRUE(tree.pose("laser", "base_link")
                  ->isApprox(at(-0.2, 0.1, 1.05, std::numbers::pi / 2).inverse()));
  tree.set("base_link", "camera", at(0.3, 0.0, 0.6));  // two branches
  EXPECT_TRUE(tree.pose("camera", "mast")->isApprox(at(-0.5, 0.0, 0.4, std::numbers::pi / 2)));
}

TEST(FrameTree, TheLastWordCountsAndALeadingSlashDoesNot) {
  FrameTree tree;
  tree.set("/base_link", "laser", at(1.0, 0.0, 0.0));
  tree.set("base_link", "/laser", at(0.2, 0.0, 0.0));
  EXPECT_TRUE(tree.pose("base_link", "/laser")->isApprox(at(0.2, 0.0, 0.0)));
}

TEST(FrameTree, KnowsNothingOfFramesThatNoLinkJoins) {
  FrameTree tree;
  EXPECT_FALSE(tree.pose("base_link", "laser"));
  tree.set("base_link", "laser", at(0.2, 0.0, 0.0));
  tree.set("map", "beacon", at(5.0, 0.0, 0.0));
  EXPECT_FALSE(tree.pose("base_link", "beacon"));
  EXPECT_FALSE(tree.pose("base_link", ""));
}

TEST(FrameTree, EndsOnARingAndIsBounded) {
  FrameTree tree;
  tree.set("a", "b", at(1.0, 0.0, 0.0));
  tree.set("b", "a", at(1.0, 0.0, 0.0));
  tree.set("a", "a", at(1.0, 0.0, 0.0));
  EXPECT_FALSE(tree.pose("base_link", "b"));
  for (std::size_t i = 0; i < FrameTree::kMost; ++i)
    tree.set("base_link", "f" + std::to_string(i), at(0.0, 0.0, 0.0));
  EXPECT_FALSE(tree.pose("base_link", "f" + std::to_string(FrameTree::kMost - 1)));
  EXPECT_TRUE(tree.pose("base_link", "f0"));
}

}  // namespace
}  // namespace tandem
