// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/motion_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tandem/local_planner/fallback.hpp"
#include "tandem/model/robot.hpp"

namespace tandem {
namespace {

const Body kMir{footprint_of(RobotParams{}), cover_by_discs(footprint_of(RobotParams{}), 0.04)};

Obstacle pole(double x, double y, double radius) {
  return {1, {x, y}, radius, radius, 0.0, {0, 0}};
}

TEST(MotionCheck, SeesAThinPoleBetweenTwoNodes) {
  const Motion motion{.X_MB = {0, 0, 0}, .dt = 1.0, .twist = {{2.0, 0.0}, {2.0, 0.0}}};
  const std::vector<Obstacle> ahead{pole(1.0, 0.2, 0.01)}, beside{pole(1.0, 0.31, 0.01)};
  EXPECT_FALSE(is_clear(kMir, motion, ahead, 2.0));
  EXPECT_TRUE(is_clear(kMir, motion, beside, 2.0));
}

TEST(MotionCheck, FollowsTheArcNotTheChord) {
  const Motion quarter{
      .X_MB = {0, 0, 0}, .dt = 1.0, .twist = {{std::numbers::pi, std::numbers::pi / 2}}};
  const std::vector<Obstacle> on_arc{pole(1.41, 0.59, 0.02)}, on_chord{pole(0.7, 1.3, 0.02)};
  EXPECT_FALSE(is_clear(kMir, quarter, on_arc, 1.0));
  EXPECT_TRUE(is_clear(kMir, quarter, on_chord, 1.0));
}

TEST(MotionCheck, ChecksNoFurtherThanRequested) {
  const Motion motion{.X_MB = {0, 0, 0}, .dt = 1.0, .twist = {{1.0, 0.0}, {1.0, 0.0}}};
  const std::vector<Obstacle> ahead{pole(2.0, 0.0, 0.1)};
  EXPECT_TRUE(is_clear(kMir, motion, ahead, 1.0));
  EXPECT_FALSE(is_clear(kMir, motion, ahead, 2.0));
}

TEST(MotionCheck, MeetsAMovingObstacleWhereItWillBe) {
  const Motion rest{.X_MB = {0, 0, 0}, .start = 0.1, .dt = 1.0, .twist = {{}, {}, {}}};
  std::vector<Obstacle> comes{pole(3.0, 0.0, 0.2)};
  comes.front().v_MO = {-1.0, 0.0};
  EXPECT_TRUE(is_clear(kMir, {.X_MB = {0, 0, 0}, .dt = 1.0, .twist = {{}}}, comes, 1.0));
  EXPECT_FALSE(is_clear(kMir, rest, comes, 3.0));
}

// is_clear() without what it skips.
bool is_clear_everywhere(const Body& body, const Motion& motion,
                         const std::vector<Obstacle>& obstacles) {
  const double radius = circumradius(body.footprint);
  Moving at{motion.X_MB, motion.moves};
  double t = motion.start;
  for (const Twist2& u : motion.twist) {
    const double v = std::max(std::abs(u.v), motion.lag.any() ? std::abs(at.twist.v) : 0.0);
    const double w = std::max(std::abs(u.w), motion.lag.any() ? std::abs(at.twist.w) : 0.0);
    const int steps = std::max(1, static_cast<int>(std::ceil((v + radius * w) * motion.dt / 0.01)));
    for (int i = 1; i <= steps; ++i) {
      const double s = motion.dt * i / steps;
      const Pose2 X = follow(at, u, motion.lag, s).X_MB;
      for (const Obstacle& obstacle : obstacles)
        if (touches(body, X, predicted(obstacle, t + s))) return false;
    }
    at = follow(at, u, motion.lag, motion.dt);
    t += motion.dt;
  }
  return true;
}

TEST(MotionCheck, MissesNothingByWhatItSkips) {
  std::mt19937 random{3};
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution{low, high}(random);
  };
  int clear = 0;
  for (int n = 0; n < 2000; ++n) {
    Motion motion{.X_MB = {uniform(-1, 1), uniform(-1, 1), uniform(-3, 3)}, .start = 0.1};
    if (n % 3 == 0) motion.lag = {0.3, 0.2};
    for (int k = 0; k < 8; ++k) motion.twist.push_back({uniform(-0.5, 1.0), uniform(-1.5, 1.5)});
    std::vector<Obstacle> obstacles;
    for (int j = 0; j < 6; ++j) {
      const double a = uniform(0.05, 0.6), b = n % 2 == 0 ? a : uniform(0.02, a);
      obstacles.push_back({.p_MO = {uniform(-3, 3), uniform(-3, 3)},
                           .a = a,
                           .b = b,
                           .angle = uniform(-3, 3),
                           .v_MO = {uniform(-0.5, 0.5), uniform(-0.5, 0.5)}});
    }
    const bool expected = is_clear_everywhere(kMir, motion, obstacles);
    EXPECT_EQ(is_clear(kMir, motion, obstacles, 8 * motion.dt), expected) << n;
    clear += expected ? 1 : 0;
  }
  EXPECT_GT(clear, 400);
  EXPECT_LT(clear, 1600);
}

TEST(MotionCheck, InsideAShapeOnlyTheWayOutIsClear) {
  const std::vector<Obstacle> over{pole(0.6, 0.0, 0.2)};  // reaches 0.083 m into the outline
  const auto twists = [](double v) { return std::vector<Twist2>(4, Twist2{v, 0.0}); };
  const Motion deeper{.X_MB = {0, 0, 0}, .dt = 0.25, .twist = twists(0.2)};
  const Motion out{.X_MB = {0, 0, 0}, .dt = 0.25, .twist = twists(-0.2)};
  const auto shrunk = passable(kMir, deeper, over);
  EXPECT_LT(shrunk.front().a, over.front().a);
  EXPECT_FALSE(is_clear(kMir, deeper, shrunk, 1.0));
  EXPECT_TRUE(is_clear(kMir, out, shrunk, 1.0));
  EXPECT_FALSE(is_clear(kMir, out, over, 1.0));
}

TEST(Fallback, BrakingStaysOnTheArcAndEndsAtRest) {
  const Start start{{0, 0, 0}, {0.8, 0.4}, 0.0};
  const Motion motion = braking(start, 0.05, 0.4, 0.4);
  EXPECT_NEAR(static_cast<double>(motion.twist.size()) * 0.05, 2.0, 0.051);
  for (const Twist2& u : motion.twist) EXPECT_NEAR(u.w, 0.5 * u.v, 1e-12);
  EXPECT_EQ(motion.twist.back(), Twist2{});
}

TEST(Fallback, RestOfAPlanKeepsItsTimeAndTheAccelerationLimits) {
  Plan plan{.t0 = 10.0, .dt = 0.25};
  plan.twist = {{0.1, 0.0}, {0.2, 0.0}, {0.3, 0.0}};
  const RobotParams robot;
  const Motion motion = rest_of(plan, {{0, 0, 0}, {0.1, 0.0}, 10.25}, 0.05, robot);
  double before = 0.1;
  for (const Twist2& u : motion.twist) {
    EXPECT_LE(std::abs(u.v - before), robot.a_max * 0.05 + 1e-12);
    before = u.v;
  }
  EXPECT_NEAR(motion.twist[4].v, 0.2, 1e-9);  // reached by then, the plan's second twist
  EXPECT_EQ(motion.twist.back(), Twist2{});
}

}  // namespace
}  // namespace tandem
