// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/guidance.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

namespace tandem {
namespace {

// Along x through the origin.
const std::vector<GuidanceLine> kLane{{"lane", {{-5.0, 0.0}, {0.0, 0.0}, {5.0, 0.0}}, 1.0, 0.8}};

TEST(Guidance, DrawsToTheLineAndAlongIt) {
  const Pose2 X = guided({1.0, 0.3, 0.4}, kLane);
  EXPECT_NEAR(X.x, 1.0, 1e-12);
  EXPECT_GT(X.y, 0.0);
  EXPECT_LT(X.y, 0.3);
  EXPECT_GT(X.theta, 0.0);
  EXPECT_LT(X.theta, 0.4);
}

TEST(Guidance, HasNoSenseOfDirection) {
  const Pose2 X = guided({1.0, 0.3, std::numbers::pi - 0.4}, kLane);
  EXPECT_LT(X.y, 0.3);
  EXPECT_GT(X.theta, std::numbers::pi - 0.4);
  EXPECT_LT(X.theta, std::numbers::pi);
}

TEST(Guidance, LeavesAloneWhatIsOnTheLineBeyondItsReachOrCrossing) {
  for (const Pose2& X : {Pose2{1.0, 0.0, 0.0}, Pose2{1.0, 1.0, 0.2}, Pose2{1.0, -3.0, 0.0},
                         Pose2{1.0, 0.3, 1.2}, Pose2{1.0, 0.3, -1.9}}) {
    const Pose2 same = guided(X, kLane);
    EXPECT_NEAR(same.x, X.x, 1e-12);
    EXPECT_NEAR(same.y, X.y, 1e-12);
    EXPECT_NEAR(same.theta, X.theta, 1e-12);
  }
}

TEST(Guidance, IsContinuousAcrossItsEdges) {
  Pose2 before = guided({1.0, -1.5, 0.0}, kLane);
  for (double y = -1.5; y <= 1.5; y += 1e-3) {  // across the reach and the line
    const Pose2 X = guided({1.0, y, 0.3}, kLane);
    EXPECT_LT(std::abs(X.y - before.y), 5e-3) << y;
    before = X;
  }
  before = guided({1.0, 0.4, 0.0}, kLane);
  for (double theta = 0.0; theta <= 3.1; theta += 1e-3) {  // across the angles
    const Pose2 X = guided({1.0, 0.4, theta}, kLane);
    EXPECT_LT(std::abs(X.y - before.y), 5e-3) << theta;
    EXPECT_LT(std::abs(X.theta - before.theta), 5e-3) << theta;
    before = X;
  }
}

TEST(Guidance, OfSeveralLinesTheStrongestCounts) {
  auto lines = kLane;
  lines.push_back({"other", {{-5.0, 0.5}, {5.0, 0.5}}, 1.0, 0.1});
  EXPECT_EQ(guided({0.0, 0.3, 0.0}, lines).y, guided({0.0, 0.3, 0.0}, kLane).y);
}

}  // namespace
}  // namespace tandem
