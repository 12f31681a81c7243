// SPDX-License-Identifier: Apache-2.0
// Tests the filter with robots whose outline is not a convex polygon.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "safety_filter/adversary.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

constexpr double kMouth = 0.25;  // [m] of the body's front, between the forks, ahead of base_link
constexpr double kInner = 0.22;  // [m] of a fork's inner side, beside base_link's x axis
constexpr double kTip = 1.15;    // [m] of the forks' ends
constexpr double kPole = 0.05;   // [m] half the side of a square pole
constexpr double kTick = 0.05;   // [s]

void add_box(RobotParams& robot, double x1, double y1, double x2, double y2) {
  for (const double value : {x1, y1, x2, y1, x2, y2, x1, y2}) robot.footprint.push_back(value);
  robot.footprint_parts.push_back(4.0);
}

// The robot of bringup/robots/fork_truck.yaml.
RobotParams fork_truck() {
  RobotParams robot;
  add_box(robot, -0.45, -0.4, kMouth, 0.4);
  add_box(robot, 0.2, -0.36, kTip, -kInner);
  add_box(robot, 0.2, kInner, kTip, 0.36);
  robot.wheel_separation = 0.6;
  return robot;
}

// A square pole at (2, 0).
std::shared_ptr<const StaticMap> one_pole() {
  Grid grid = free_grid(8.0);
  occupy(grid, [](double x, double y) { return std::abs(x - 2.0) < kPole && std::abs(y) < kPole; });
  return as_map(std::move(grid));
}

// The pose with the pole between the forks and the body `gap` before it.
Pose2 around_the_pole(double gap) { return {2.0 - kPole - kMouth - gap, 0.0, 0.0}; }

class ForkTruck : public testing::Test {
 protected:
  void drive(const Twist2& twist, double duration) {
    for (double t = 0.0; t < duration; t += kTick) (void)loop_.tick(twist, kTick);
  }
  [[nodiscard]] Pose2 X_MB() const { return loop_.sim().state().X_MB; }

  Random random_{1};
  std::shared_ptr<const StaticMap> map_ = one_pole();
  ClosedLoop loop_{{}, fork_truck(), {}, map_, random_};
};

TEST_F(ForkTruck, DrivesUntilAPoleStandsBetweenItsForksAndStopsBeforeItsBodyTouchesThePole) {
  loop_.start_at({0.0, 0.0, 0.0});
  drive({0.4, 0.0}, 12.0);
  EXPECT_TRUE(loop_.stands());
  EXPECT_EQ(loop_.sim().contacts().count, 0u);
  EXPECT_GT(X_MB().x + kTip, 2.0 + kPole + 0.5);  // the pole is deep between the forks
  const double gap = 2.0 - kPole - kMouth - X_MB().x;
  EXPECT_GE(gap, loop_.filter().hard_margin());
  EXPECT_LE(gap, loop_.filter().hard_margin() + loop_.filter().params().band + 0.005);
  EXPECT_NEAR(map_->clearance(loop_.sim().footprint(), X_MB(), 1.0), gap, 1e-9);
}

TEST_F(ForkTruck, BacksOutWithAPoleBetweenItsForks) {
  loop_.start_at(around_the_pole(0.05));
  drive({-0.3, 0.0}, 6.0);
  EXPECT_LT(X_MB().x + kTip, 2.0 - kPole);
  EXPECT_EQ(loop_.sim().contacts().count, 0u);
}

TEST_F(ForkTruck, TurnsUntilAForkIsBesideThePole) {
  for (const double w : {0.5, -0.5}) {
    loop_.start_at(around_the_pole(0.3));
    drive({0.0, w}, 4.0);
    EXPECT_TRUE(loop_.stands());
    EXPECT_GT(std::abs(X_MB().theta), 0.1);
    EXPECT_LT(std::abs(X_MB().theta), 0.4);
    EXPECT_EQ(loop_.sim().contacts().count, 0u);
  }
}

// The pole touches the left fork from inside. A left turn leads away from it, a right turn deeper.
TEST_F(ForkTruck, TurnsOutOfAContactBetweenItsForksAndNotDeeper) {
  const Pose2 start{2.0 - 0.7, -kInner + kPole - 0.01, 0.0};
  loop_.start_at(start);
  EXPECT_EQ(map_->clearance(loop_.sim().footprint(), start, 1.0), 0.0);
  drive({0.0, -0.3}, 1.0);
  EXPECT_EQ(X_MB().theta, 0.0);
  drive({0.0, 0.3}, 2.0);
  EXPECT_GT(map_->clearance(loop_.sim().footprint(), X_MB(), 1.0), loop_.filter().hard_margin());
}

TEST_F(ForkTruck, TouchesNothingBetweenItsForksWhateverIsCommanded) {
  for (unsigned seed = 1; seed <= samples(28, 7); ++seed) {
    loop_.start_at(around_the_pole(uniform(random_, 0.04, 0.6)));
    loop_.draw_pose_error(seed % 2 == 0);
    Adversary adversary(static_cast<Malice>(seed % kMalices), fork_truck(), random_);
    for (unsigned i = 0; i < samples(400, 150); ++i)
      (void)loop_.tick(adversary.command(X_MB(), loop_.sim().footprint(), *map_), kTick);
    EXPECT_EQ(loop_.sim().contacts().count, 0u) << seed;
  }
}

}  // namespace
}  // namespace tandem::test
