// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/given_path.hpp"

#include <gtest/gtest.h>

namespace tandem::test {
namespace {

using Points = std::vector<Eigen::Vector2d>;

GivenPath along(const Points& points) {
  GivenPath path;
  path.follow(points);
  return path;
}

TEST(GivenPath, HasPointsAtTheSpacing) {
  const GivenPath path = along({{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.0}, {1.0, 0.53}});
  EXPECT_NEAR(path.length(), 1.53, 1e-9);
  EXPECT_EQ(path.points().back(), Eigen::Vector2d(1.0, 0.53));
  for (std::size_t i = 1; i < path.points().size(); ++i)
    EXPECT_LT((path.points()[i] - path.points()[i - 1]).norm(), 1.5 * GivenPath::kSpacing + 1e-9);
}

TEST(GivenPath, LosesWhatTheRobotHasPassed) {
  GivenPath path = along({{0.0, 0.0}, {1.0, 0.0}});
  path.advance({0.6, 0.2});
  EXPECT_NEAR(path.length(), 0.4, 1e-9);
  path.advance({5.0, 0.0});
  EXPECT_EQ(path.length(), 0.0);
}

// Its end is not taken for the robot's place.
TEST(GivenPath, ThatIsClosedIsFollowedFromItsBeginning) {
  GivenPath path = along({{0.0, 0.0}, {3.0, 0.0}, {3.0, 3.0}, {0.0, 3.0}, {0.0, 0.0}});
  path.advance({0.0, 0.0});
  EXPECT_NEAR(path.length(), 12.0, 1e-9);
}

}  // namespace
}  // namespace tandem::test
