// SPDX-License-Identifier: Apache-2.0
// Tests the filter in closed loop with the simulated base.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "safety_filter/adversary.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

// At speed the robot stops before the soft band; if pushed further, it creeps up to the hard
// margin.
TEST(SafetyFilterLoop, StopsBeforeAWallCloseToTheMargin) {
  Random random(1);
  ClosedLoop loop({}, kMir, {}, wall_ahead(), random);
  loop.start_at({0.0, 0.0, 0.0});
  for (int i = 0; i < 120; ++i) (void)loop.tick({0.8, 0.0}, 0.05);  // 6 s for 1 m
  EXPECT_TRUE(loop.stands());
  const double gap = 1.5 - kBumper - loop.sim().state().X_MB.x;
  EXPECT_GE(gap, loop.filter().hard_margin());
  EXPECT_LE(gap, loop.filter().hard_margin() + loop.filter().params().band + 0.005);
}

// Time constant, braking and speed at which modelling the lag as a delay would end in the wall.
TEST(SafetyFilterLoop, AFirstOrderMotorStopsBeforeTheWallFromFullSpeed) {
  for (const auto& [lag, a_brake, v] : {std::array{0.30, 1.5, 1.5}, std::array{0.30, 2.5, 1.0},
                                        std::array{0.40, 1.0, 0.8}, std::array{0.50, 2.0, 3.0}}) {
    RobotParams robot = kMir;
    robot.motor_lag = lag;
    robot.a_brake = a_brake;
    robot.v_max = v;
    DiffDriveSimParams base;
    base.drive.a_drive = 5.0;
    Grid grid = free_grid(30.0);
    occupy(grid, [](double x, double) { return x > 12.0; });
    Random random(1);
    ClosedLoop loop({}, robot, base, as_map(std::move(grid)), random);
    loop.start_at({-12.0, 0.0, 0.0});
    for (int i = 0; i < 1200; ++i) (void)loop.tick({v, 0.0}, 0.05);  // 60 s for 24 m
    EXPECT_EQ(loop.sim().contacts().count, 0u) << lag << ' ' << a_brake << ' ' << v;
    EXPECT_GE(loop.sim().min_clearance(), loop.filter().hard_margin() - 0.005);
    EXPECT_GT(loop.sim().state().X_MB.x, 12.0 - kBumper - 0.1);  // it reached the wall
  }
}

TEST(SafetyFilterLoop, HugsAWallWithoutGettingStuck) {
  Grid grid = free_grid(8.0);
  occupy(grid, [](double, double y) { return y > 0.5 && y < 0.7; });
  Random random(2);
  ClosedLoop loop({}, kMir, {}, as_map(std::move(grid)), random);
  loop.start_at({-3.0, 0.0, 0.1});
  for (int i = 0; i < 400; ++i) {  // 20 s, always pushed against the wall on the left
    const double steer = 1.0 * (0.05 - loop.sim().state().X_MB.theta);
    (void)loop.tick({0.5, steer}, 0.05);
  }
  EXPECT_EQ(loop.sim().contacts().count, 0u);
  const double stuck_at = loop.sim().state().X_MB.x;
  for (int i = 0; i < 100; ++i) {  // 5 s straight on and away
    const double steer = 1.0 * (-0.1 - loop.sim().state().X_MB.theta);
    (void)loop.tick({0.3, steer}, 0.05);
  }
  EXPECT_GT(loop.sim().state().X_MB.x - stuck_at, 0.5);
}

// Steers along y = 0 with a noisy hand, through a door 0.80 m wide in a wall 0.2 m thick.
TEST(SafetyFilterLoop, LetsAMirThroughADoorItIsSteeredThrough) {
  Grid grid = free_grid(8.0);
  occupy(grid, [](double x, double y) { return std::abs(x) < 0.1 && std::abs(y) > 0.4; });
  const auto map = as_map(std::move(grid));
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    ClosedLoop loop({}, kMir, {}, map, random);
    loop.start_at({-2.0, 0.02, 0.02});
    int changed = 0, ticks = 0;
    for (; ticks < 200 && loop.sim().state().X_MB.x < 1.0; ++ticks) {
      const Pose2 X = loop.sim().state().X_MB;
      const double w = -1.5 * X.theta - 1.5 * X.y + uniform(random, -0.1, 0.1);
      changed += loop.tick({0.5, w}, 0.05).scale < 1.0 ? 1 : 0;
    }
    EXPECT_GE(loop.sim().state().X_MB.x, 1.0) << seed;
    EXPECT_EQ(loop.sim().contacts().count, 0u);
    EXPECT_LE(changed, ticks / 20) << seed;
  }
}

// Runs with noise, slip and an adversary for a minute each. Measured clearance may fall below the
// margin, but the errors must not add up to a contact.
TEST(SafetyFilterLoop, CannotBeRatchetedIntoTheWall) {
  const auto map = wall_ahead();
  SafetyFilterParams params;
  for (unsigned seed = 1; seed <= samples(12, kMalices, 48); ++seed) {
    Random random(seed);
    DiffDriveSimParams sim;
    sim.max_step = 0.01;
    sim.drive.slip = params.slip;
    ClosedLoop loop(params, kMir, sim, map, random);
    // facing the wall, or alongside it
    const double side = seed % 2 ? 0.0 : 0.5 * std::numbers::pi;
    const double reach = seed % 2 ? kBumper : 0.29;
    loop.start_at({1.5 - reach - 0.02, 0.0, side});
    loop.draw_pose_error(true);
    Adversary adversary(static_cast<Malice>(seed % kMalices), kMir, random);
    for (unsigned i = 0; i < samples(1200, 100); ++i)
      (void)loop.tick(adversary.command(loop.sim().state().X_MB, loop.sim().footprint(), *map),
                      0.05);
    EXPECT_EQ(loop.sim().contacts().count, 0u) << seed;
    EXPECT_GT(loop.sim().min_clearance(), 0.002) << seed;
  }
}

}  // namespace
}  // namespace tandem::test
