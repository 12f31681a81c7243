// SPDX-License-Identifier: Apache-2.0
#include "tandem/diff_drive_sim/diff_drive_sim.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace tandem {
namespace {

constexpr double kBumper = 0.038 + 0.445;  // of the MiR 100, ahead of base_link [m]
const RobotParams kMir{};

// 8 m × 8 m around the origin, with a wall from x = 1.5 on.
std::shared_ptr<const StaticMap> wall_ahead() {
  Grid grid;
  grid.width = grid.height = 160;
  grid.origin = {-4.0, -4.0};
  grid.cells.assign(160 * 160, Cell::kFree);
  for (std::size_t i = 0; i < grid.cells.size(); ++i)
    if (grid.center(static_cast<int>(i % 160), 0).x() > 1.5) grid.cells[i] = Cell::kOccupied;
  return std::make_shared<const StaticMap>(std::move(grid));
}

class DiffDriveSimTest : public ::testing::Test {
 protected:
  explicit DiffDriveSimTest(const DiffDriveSimParams& params = {})
      : sim_{params, kMir, wall_ahead(), 1} {}

  // Sends the command every 20 ms for `duration`.
  void drive(const Twist2& command, double duration) {
    const double end = sim_.state().t + duration;
    while (sim_.state().t < end - 1e-9) {
      sim_.command(command, sim_.state().t);
      sim_.advance_to(std::min(end, sim_.state().t + 0.02));
    }
  }
  [[nodiscard]] double gap() const { return 1.5 - kBumper - sim_.state().X_MB.x; }

  DiffDriveSim sim_;
};

TEST_F(DiffDriveSimTest, ReachesTheCommandedTwist) {
  drive({0.5, 0.3}, 2.0);
  EXPECT_NEAR(sim_.state().twist.v, 0.5, 1e-6);
  EXPECT_NEAR(sim_.state().twist.w, 0.3, 1e-6);
}

TEST_F(DiffDriveSimTest, DrivesACircle) {
  sim_.reset({-2.0, -1.0, 0.0}, 1);
  drive({0.4, 0.5}, 1.0);
  const Pose2 start = sim_.state().X_MB;
  drive({0.4, 0.5}, 2.0 * std::numbers::pi / 0.5);
  EXPECT_NEAR(sim_.state().X_MB.x, start.x, 1e-3);
  EXPECT_NEAR(sim_.state().X_MB.y, start.y, 1e-3);
  EXPECT_NEAR(sim_.state().X_MB.theta - start.theta, 2.0 * std::numbers::pi, 1e-3);
}

TEST_F(DiffDriveSimTest, ActsOnACommandAfterTheDelay) {
  sim_.command({0.8, 0.0}, 0.0);
  sim_.advance_to(kMir.command_delay);
  EXPECT_EQ(sim_.state().twist.v, 0.0);
  sim_.advance_to(kMir.command_delay + 0.01);
  EXPECT_GT(sim_.state().twist.v, 0.0);
}

TEST_F(DiffDriveSimTest, ClipsACommandToTheRobotsLimitsAndIgnoresNaN) {
  sim_.reset({-3.0, 0.0, 0.0}, 1);
  drive({50.0, 0.0}, 1.5);
  EXPECT_NEAR(sim_.state().twist.v, kMir.v_max, 1e-6);
  sim_.command({std::numeric_limits<double>::quiet_NaN(), 0.0}, sim_.state().t);
  sim_.advance_to(sim_.state().t + 0.05);
  EXPECT_NEAR(sim_.state().twist.v, kMir.v_max, 1e-6);
}

TEST_F(DiffDriveSimTest, BrakesAsStronglyAsTheRobotDeclares) {
  sim_.reset({-3.0, 0.0, 0.0}, 1);
  drive({0.8, 0.0}, 2.0);
  const double x = sim_.state().X_MB.x, t = sim_.state().t;
  drive({}, kMir.command_delay + 0.8 / kMir.a_brake + 0.1);
  EXPECT_LT(sim_.state().twist.v, 0.02);
  drive({}, 1.0);
  EXPECT_LE(sim_.state().X_MB.x - x, 0.8 * (kMir.command_delay + kMir.motor_lag) +
                                         0.8 * 0.8 / (2.0 * kMir.a_brake) + 0.8 * 0.005);
  EXPECT_GT(sim_.state().t, t);
}

TEST_F(DiffDriveSimTest, StopsByItselfWhenCommandsCease) {
  sim_.reset({-3.0, 0.0, 0.0}, 1);
  drive({0.8, 0.0}, 1.5);
  sim_.advance_to(sim_.state().t + 0.2 + 0.8 / kMir.a_brake);
  EXPECT_LT(sim_.state().twist.v, 0.02);
}

TEST_F(DiffDriveSimTest, ReportsOdometryOfThePast) {
  sim_.reset({-1.0, 0.5, 0.3}, 1);
  drive({0.5, 0.4}, 1.0);
  const SimState then = sim_.state();
  sim_.advance_to(then.t + kMir.sensor_delay);
  const OdometryReport report = sim_.odometry();
  EXPECT_NEAR(report.t, then.t, 1e-9);
  const Pose2 X_MB = compose(report.X_MW, report.X_WB);
  EXPECT_NEAR(X_MB.x, then.X_MB.x, 1e-9);
  EXPECT_NEAR(X_MB.y, then.X_MB.y, 1e-9);
  EXPECT_NEAR(X_MB.theta, then.X_MB.theta, 1e-9);
  EXPECT_NEAR(report.twist.v, then.twist.v, 1e-9);
  EXPECT_LT(std::hypot(report.X_WB.x, report.X_WB.y), 0.6);  // odometry began at zero
}

TEST_F(DiffDriveSimTest, RestsAtTheWallWithoutEnteringIt) {
  drive({0.8, 0.0}, 4.0);
  EXPECT_GT(gap(), 0.0);
  EXPECT_LT(gap(), 1e-3);
  EXPECT_EQ(sim_.contacts().count, 1u);
  EXPECT_TRUE(sim_.contacts().in_contact);
  EXPECT_NEAR(sim_.contacts().p_MQ.x(), 1.525, 1e-6);
  EXPECT_LT(sim_.min_clearance(), 1e-3);
}

TEST_F(DiffDriveSimTest, LetsTheRobotBackOutOfContactAndTurnAway) {
  drive({0.8, 0.0}, 3.0);
  drive({-0.4, 0.0}, 1.0);
  EXPECT_GT(gap(), 0.2);
  sim_.reset({1.5 - 0.2901, 0.0, 0.5 * std::numbers::pi}, 1);  // the right side at the wall
  drive({0.0, -1.0}, 0.5);                                     // swings the nose into it
  EXPECT_EQ(sim_.contacts().count, 1u);
  const double theta = sim_.state().X_MB.theta;
  drive({-0.1, 1.0}, 0.3);
  EXPECT_NE(sim_.state().X_MB.theta, theta);
}

TEST_F(DiffDriveSimTest, CountsPushingAsOneContactAndReturningAsAnother) {
  drive({0.8, 0.0}, 4.0);
  drive({-0.4, 0.0}, 0.24);  // off by more than 0.05 m, but not for half a second
  drive({0.8, 0.0}, 0.8);
  EXPECT_EQ(sim_.contacts().count, 1u);
  drive({-0.4, 0.0}, 1.5);
  EXPECT_FALSE(sim_.contacts().in_contact);
  drive({0.8, 0.0}, 3.0);
  EXPECT_EQ(sim_.contacts().count, 2u);
}

TEST_F(DiffDriveSimTest, LetsARobotPutIntoAnObstacleLeaveIt) {
  sim_.reset({1.6, 0.0, 0.0}, 1);
  EXPECT_EQ(sim_.contacts().count, 1u);
  drive({-0.4, 0.0}, 3.0);
  EXPECT_GT(gap(), 0.0);
  EXPECT_EQ(sim_.contacts().count, 1u);
}

TEST_F(DiffDriveSimTest, ScansTheWall) {
  const Pose2& X_MB = sim_.state().X_MB;
  EXPECT_NEAR(sim_.beam(X_MB, 180, 360, 10.0), 1.5, 1e-6);  // straight ahead
  EXPECT_EQ(sim_.beam(X_MB, 0, 360, 10.0), 10.0);           // straight behind
}

TEST(BeamAngle, SpreadsTheBeamsOverTheScansWidth) {
  EXPECT_NEAR(beam_angle(0, 360, kAllAround), -std::numbers::pi, 1e-12);
  EXPECT_NEAR(beam_angle(359, 360, kAllAround), std::numbers::pi - kAllAround / 360, 1e-12);
  EXPECT_NEAR(beam_angle(0, 181, std::numbers::pi), -0.5 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(beam_angle(90, 181, std::numbers::pi), 0.0, 1e-12);
  EXPECT_NEAR(beam_angle(180, 181, std::numbers::pi), 0.5 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(beam_angle(0, 1, 1.0), -0.5, 1e-12);
}

TEST_F(DiffDriveSimTest, NeedsAMap) {
  EXPECT_THROW(DiffDriveSim({}, kMir, nullptr, 1), std::invalid_argument);
  DiffDriveSimParams params;
  params.drive.slip = 2.0;
  EXPECT_THROW(DiffDriveSim(params, kMir, wall_ahead(), 1), std::invalid_argument);
}

DiffDriveSimParams slippery() {
  DiffDriveSimParams params;
  params.drive.slip = 0.05;
  params.odometry_noise = 0.02;
  return params;
}

class SlipperyDiffDriveSimTest : public DiffDriveSimTest {
 protected:
  SlipperyDiffDriveSimTest() : DiffDriveSimTest(slippery()) {}

  Pose2 run(unsigned seed) {
    sim_ = DiffDriveSim(slippery(), kMir, wall_ahead(), seed);
    sim_.reset({-3.0, 0.0, 0.0}, seed);
    drive({0.5, 0.2}, 4.0);
    return sim_.state().X_MB;
  }
};

TEST_F(SlipperyDiffDriveSimTest, RepeatsItselfBitForBitWithTheSameSeed) {
  const Pose2 first = run(7);
  EXPECT_EQ(run(7), first);
  EXPECT_NE(run(8), first);
}

TEST_F(SlipperyDiffDriveSimTest, LetsOdometryDriftWhileTheTransformCorrectsIt) {
  const Pose2 X_MB = run(7);
  sim_.advance_to(sim_.state().t + 1.0);  // stands, so the delay does not matter
  const OdometryReport report = sim_.odometry();
  const Pose2 start{-3.0, 0.0, 0.0};
  const Pose2 by_odometry = compose(start, report.X_WB);
  EXPECT_GT(std::hypot(by_odometry.x - X_MB.x, by_odometry.y - X_MB.y), 1e-3);
  const Pose2 corrected = compose(report.X_MW, report.X_WB);
  EXPECT_NEAR(corrected.x, sim_.state().X_MB.x, 1e-6);
}

}  // namespace
}  // namespace tandem
