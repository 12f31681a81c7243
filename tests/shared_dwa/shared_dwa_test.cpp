// SPDX-License-Identifier: Apache-2.0
#include "tandem/shared_dwa/shared_dwa.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include <cmath>
#include <limits>

#include "safety_filter/scenes.hpp"
#include "support/instrumented.hpp"

namespace tandem::test {
namespace {

constexpr unsigned kWorlds = samples(100, 4), kDrives = samples(15, 2);

const RobotParams kMir{};
constexpr double kBumper = 0.038 + 0.445;  // [m] ahead of base_link
constexpr double kPeriod = 0.05;

std::shared_ptr<const StaticMap> empty() { return as_map(free_grid(10.0)); }

std::shared_ptr<const StaticMap> wall_at(double x_wall) {
  Grid grid = free_grid(10.0);
  occupy(grid, [&](double x, double) { return x > x_wall && x < x_wall + 0.2; });
  return as_map(std::move(grid));
}

// The base of the filter's tests, without its filter.
DiffDriveSim simulation(std::shared_ptr<const StaticMap> map, const Pose2& X_MB) {
  DiffDriveSim sim{{}, kMir, std::move(map), 1};
  sim.reset(X_MB, 1);
  return sim;
}

// Drives with a constant command; ends early on contact.
void drive(DiffDriveSim& sim, const SharedDwa& dwa, const Twist2& user, const StaticMap& map,
           double duration) {
  for (double end = sim.state().t + duration; sim.state().t < end && !sim.contacts().count;) {
    const double t = sim.state().t;
    const OdometryReport report = sim.odometry();
    sim.command(dwa.choose(compose(report.X_MW, report.X_WB), report.twist, user, map).command, t);
    sim.advance_to(t + kPeriod);
  }
}

TEST(SharedDwa, PassesThePersonsCommandWhereNothingIsNear) {
  const SharedDwa dwa{{}, kMir};
  for (const Twist2& user : {Twist2{0.3, 0.2}, Twist2{-0.2, 0.0}, Twist2{0.0, 0.5}, Twist2{}}) {
    const DwaChoice choice = dwa.choose({}, {}, user, *empty());
    EXPECT_EQ(choice.command, user);
    EXPECT_EQ(choice.looked_at, 1);
    EXPECT_EQ(choice.cost, 0.0);
  }
}

TEST(SharedDwa, StaysWithinTheWindowAndTheRobotsLimits) {
  const SharedDwa dwa{{.window = 0.1}, kMir};
  const DwaChoice choice = dwa.choose({}, {0.5, 0.0}, {5.0, 5.0}, *empty());
  EXPECT_LE(choice.command.v, 0.5 + 0.1 * kMir.a_brake + 1e-12);
  EXPECT_LE(choice.command.w, 0.1 * kMir.alpha_brake + 1e-12);
  EXPECT_LE(SharedDwa({.window = 2.0}, kMir).choose({}, {}, {5.0, 0.0}, *empty()).command.v,
            kMir.v_max);
}

TEST(SharedDwa, SteersRoundAPoleThatIsPushedAt) {
  const SharedDwa dwa{{}, kMir};
  for (const double offset : {-0.3, -0.1, 0.1, 0.3}) {
    Grid grid = free_grid(10.0);
    add_pole(grid, 2.0, offset, 0.2);
    const auto map = as_map(std::move(grid));
    DiffDriveSim sim = simulation(map, {});
    drive(sim, dwa, {0.6, 0.0}, *map, 12.0);
    EXPECT_EQ(sim.contacts().count, 0u) << offset;
    EXPECT_GT(std::hypot(sim.state().X_MB.x, sim.state().X_MB.y), 2.5) << offset;
  }
}

TEST(SharedDwa, BacksOutWhenItStandsInsideTheMargin) {
  const auto map = wall_at(1.5);
  const SharedDwa dwa{{}, kMir};
  DiffDriveSim sim = simulation(map, {1.5 - kBumper - 0.02, 0.0, 0.0});
  drive(sim, dwa, {-0.3, 0.0}, *map, 3.0);
  EXPECT_EQ(sim.contacts().count, 0u);
  EXPECT_LT(sim.state().X_MB.x, 0.5);
}

TEST(SharedDwa, BrakesWhenNothingIsAdmissible) {
  const auto map = wall_at(1.5);
  const DwaChoice choice =
      SharedDwa{{}, kMir}.choose({1.5 - kBumper - 0.1, 0.0, 0.0}, {0.8, 0.0}, {0.8, 0.0}, *map);
  EXPECT_FALSE(choice.admissible);
  EXPECT_EQ(choice.command, Twist2{});
}

// The chosen command, braked along its arc, must end clear of all obstacles; checked in small exact
// steps.
TEST(SharedDwa, WhatItChoosesEndsClearInAnyWorld) {
  int drove = 0, near = 0, kept = 0;
  for (unsigned seed = 1; seed <= kWorlds; ++seed) {
    Random random(seed);
    const RobotParams robot = random_robot(random);
    const auto map = random_map(random);
    const Footprint footprint = footprint_of(robot);
    const SharedDwaParams params;
    const SharedDwa dwa{params, robot};
    for (int i = 0; i < 20; ++i) {
      Pose2 X;
      if (!find_free_pose(random, *map, footprint, 0.03, X)) break;
      const Twist2 measured{uniform(random, robot.v_min, robot.v_max),
                            uniform(random, -robot.w_max, robot.w_max)};
      const Twist2 user{uniform(random, robot.v_min, robot.v_max),
                        uniform(random, -robot.w_max, robot.w_max)};
      const double room = map->clearance(footprint, X, 1.0);
      const DwaChoice choice = dwa.choose(X, measured, user, *map);
      if (!choice.admissible || choice.command == Twist2{}) continue;
      ++drove;
      const double delay = robot.command_delay + robot.sensor_delay + robot.motor_lag;
      X = integrate(X, measured, delay);
      const Twist2 twist = choice.command;
      const double braking =
          std::max(std::abs(twist.v) / robot.a_brake, std::abs(twist.w) / robot.alpha_brake);
      const double to_rest = params.control_period + 0.5 * braking;
      double least = 1.0;
      for (int k = 0; k <= 200; ++k)
        least =
            std::min(least, map->clearance(footprint, integrate(X, twist, to_rest * k / 200), 1.0));
      EXPECT_GT(least, 0.0) << seed;
      kept += least > std::min(params.margin, room) - 0.01 ? 1 : 0;
      near += least < 0.1 ? 1 : 0;
    }
  }
  EXPECT_GT(drove, 5 * static_cast<int>(kWorlds));
  EXPECT_GT(near, static_cast<int>(kWorlds) / 2);  // it was not all empty space
  EXPECT_GT(kept, 0.9 * drove);
}

TEST(SharedDwa, NeverTouchesWhateverThePersonDoes) {
  for (unsigned seed = 1; seed <= kDrives; ++seed) {
    Random random(seed);
    const auto map = random_map(random);
    const SharedDwa dwa{{}, kMir};
    Pose2 start;
    if (!find_free_pose(random, *map, footprint_of(kMir), 0.1, start)) continue;
    DiffDriveSim sim = simulation(map, start);
    for (int i = 0; i < 8; ++i)
      drive(sim, dwa, {uniform(random, -0.4, 0.8), uniform(random, -1.0, 1.0)}, *map, 1.5);
    EXPECT_EQ(sim.contacts().count, 0u) << seed;
  }
}

TEST(SharedDwaParams, RejectsAParameterOutsideItsRange) {
  EXPECT_THROW(SharedDwa({.v_samples = 1}, kMir), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::test
