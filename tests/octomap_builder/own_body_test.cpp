// SPDX-License-Identifier: Apache-2.0
#include "tandem/octomap_builder/own_body.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tandem/octomap_builder/local_map.hpp"

namespace tandem {
namespace {

// A scanner at the robot's front that looks back over the robot.
const Eigen::Isometry3d kLookingBack =
    Eigen::Translation3d(0.4, 0.0, 0.3) *
    Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ());

RangeReturns echoes_at(std::vector<Eigen::Vector3d> p_SQ) { return {std::move(p_SQ), {}, {}}; }

TEST(OwnBody, ReturnsInsideTheOutlineAreDroppedWhereverTheSensorIs) {
  const OwnBody body{rectangle(0.9, 0.6, 0.0)};
  RangeReturns echoes = echoes_at({{0.3, 0.2, 0.0},     // a post
                                   {0.1, 0.0, 0.9},     // an arm above it
                                   {-0.04, 0.0, 0.0},   // a footplate
                                   {-0.06, 0.0, 0.0},   // just beyond it
                                   {0.3, 0.31, 0.0}});  // beside the robot
  EXPECT_EQ(body.drop(echoes, kLookingBack), 3U);
  ASSERT_EQ(echoes.p_SQ.size(), 2U);
  EXPECT_EQ(echoes.p_SQ[0].x(), -0.06);
}

// Two forks and the mast that joins them: objects between the forks are not part of the robot.
TEST(OwnBody, IsTheUnionOfTheOutlinesParts) {
  const OwnBody body{polygons({{{-0.2, -0.4}, {0.1, -0.4}, {0.1, 0.4}, {-0.2, 0.4}},
                               {{0.1, 0.2}, {1.0, 0.2}, {1.0, 0.4}, {0.1, 0.4}},
                               {{0.1, -0.4}, {1.0, -0.4}, {1.0, -0.2}, {0.1, -0.2}}})};
  RangeReturns echoes = echoes_at({{0.8, 0.3, 0.0}, {0.8, 0.0, 0.0}, {0.8, -0.3, 0.0}});
  EXPECT_EQ(body.drop(echoes, Eigen::Isometry3d::Identity()), 2U);
  ASSERT_EQ(echoes.p_SQ.size(), 1U);
  EXPECT_EQ(echoes.p_SQ[0].y(), 0.0);
}

// A post is seen from outside and then from within the outline. The beam that ends on the robot's
// own body behind the post must not clear it.
TEST(OwnBody, BeamsThatEndOnItClearNothing) {
  const OwnBody body{rectangle(0.9, 0.6, 0.0)};
  LocalMap map({});
  const auto insert = [&](RangeReturns echoes, double x) {
    body.drop(echoes, Eigen::Isometry3d::Identity());
    const Look look{std::move(echoes), Eigen::Isometry3d{Eigen::Translation3d(x, 0.0, 0.3)}};
    EXPECT_TRUE(map.insert({&look, 1}, 1.0));
  };
  insert(echoes_at({{1.21, 0.0, 0.0}}), -1.0);  // at x = 0.21 in the map
  for (int i = 0; i < 20; ++i) insert(echoes_at({{0.41, 0.0, 0.0}}), 0.0);
  const auto* voxel = map.tree().search(0.211, 0.0, 0.3);
  ASSERT_NE(voxel, nullptr);
  EXPECT_TRUE(map.tree().isNodeOccupied(voxel));
}

}  // namespace
}  // namespace tandem
