// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/safety_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "safety_filter/filtering.hpp"

namespace tandem::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(SafetyFilter, PassesAClearCommandUnchanged) {
  for (const Twist2 command : {Twist2{0.8, 0.3}, Twist2{-0.4, -1.0}, Twist2{0.0, 1.0}}) {
    const Filtered out = once(command, at(-2.0));
    EXPECT_EQ(out.reason, FilterReason::kClear);
    EXPECT_EQ(out.twist, command);
    EXPECT_EQ(out.scale, 1.0);
  }
}

TEST(SafetyFilter, SlowsAlongTheSameArc) {
  const Twist2 command{0.8, 0.2};
  const Filtered out = once(command, facing_wall(0.15));
  EXPECT_EQ(out.reason, FilterReason::kSlowed);
  EXPECT_GT(out.twist.v, 0.05);
  EXPECT_LT(out.twist.v, 0.7);
  EXPECT_NEAR(out.twist.w / out.twist.v, command.w / command.v, 1e-12);
  EXPECT_NEAR(out.twist.v, out.scale * command.v, 1e-12);
}

// Pushing stops before the soft band; slow manoeuvres, such as a corner that swings out, may use
// it.
TEST(SafetyFilter, KeepsTheBandForManoeuvres) {
  const SafetyFilterParams params;
  const RobotState state = facing_wall(0.0247 + params.band);
  EXPECT_EQ(once({0.8, 0.0}, state).twist, Twist2{});
  EXPECT_EQ(once({0.11, 0.0}, state).twist, Twist2{});
  const Filtered slow = once({0.0, 0.1}, state);
  EXPECT_GT(slow.twist.w, 0.02);
  const Filtered forward = once({0.09, 0.0}, state);
  EXPECT_GT(forward.twist.v, 0.005);
  EXPECT_LT(forward.twist.v, 0.08) << "down to the hard margin, and no further";
}

TEST(SafetyFilter, AllowsMoreSpeedFurtherAway) {
  double last = 0.0;
  for (double gap = 0.03; gap < 1.0; gap += 0.01) {
    const double v = once({0.8, 0.0}, facing_wall(gap)).twist.v;
    EXPECT_GE(v, last) << gap;
    last = v;
  }
  EXPECT_EQ(last, 0.8);
}

TEST(SafetyFilter, ClipsACommandBeyondTheRobotsLimits) {
  const Filtered out = once({1e300, 0.0}, at(-2.0));
  EXPECT_EQ(out.reason, FilterReason::kSlowed);
  EXPECT_EQ(out.twist, (Twist2{kMir.v_max, 0.0}));
}

TEST(SafetyFilter, CountsTheMeasuredSpeedNotOnlyTheCommand) {
  const RobotState slow = facing_wall(0.3), fast = facing_wall(0.3, {0.8, 0.0});
  EXPECT_EQ(once({0.3, 0.0}, slow).reason, FilterReason::kClear);
  EXPECT_EQ(once({0.3, 0.0}, fast).reason, FilterReason::kStopped);
}

// The bound allows odometry to be 0.5 s old, but here it is current, so the commands since have
// already acted. The robot turns away from a wall; with old odometry it would now face elsewhere.
TEST(SafetyFilter, CountsFreshOdometryAsWellAsOld) {
  RobotParams robot = kMir;
  robot.v_max = 2.5;
  robot.w_max = 1.66;
  robot.sensor_delay = 0.5;
  SafetyFilter filter(SafetyFilterParams{}, robot);
  filter.on_map(as_map(free_grid(20.0)));
  const Twist2 turning{0.0, -robot.w_max};
  RobotState state = facing_wall(0.4, turning);
  for (double t = -1.0; t < -0.01; t += 0.05) {
    state.X_MB.theta = turning.w * t;
    state.t = t;
    filter.on_command(turning, t);
    EXPECT_EQ(filter.update(state, t).twist, turning);
  }
  filter.on_map(wall_ahead());
  filter.on_command({1.22, 0.0}, 0.0);
  EXPECT_LT(filter.update(facing_wall(0.4, turning), 0.0).twist.v, 0.9);
}

TEST(SafetyFilter, ReportsRefusalOnlyWhenAnObstacleCausesIt) {
  const RobotState state = facing_wall(0.026);
  EXPECT_TRUE(once({0.8, 0.0}, state).refused);
  EXPECT_FALSE(once({0.0, 0.0}, state).refused) << "an emergency stop, a stick let go";
  EXPECT_FALSE(once({-0.4, 0.0}, state).refused);
  EXPECT_FALSE(once({0.8, 0.0}, facing_wall(0.15)).refused) << "slowed";
  EXPECT_FALSE(once({0.8, 0.0}, state, nullptr).refused) << "no map";
  SafetyFilter watching = filter_on(wall_ahead(), {.enforce = false});
  watching.on_command({0.8, 0.0}, 0.0);
  EXPECT_FALSE(watching.update(state, 0.0).refused);
}

TEST(SafetyFilter, LimitsTurningInPlaceBesideAWall) {
  Grid grid = free_grid(6.0);
  occupy(grid, [](double, double y) { return y > 0.35; });  // 0.06 m beside the robot
  const Filtered out = once({0.0, 1.0}, at(0.0), as_map(std::move(grid)));
  EXPECT_LT(out.twist.w, 0.5);
}

TEST(SafetyFilter, TurnsWhenTheWayAheadIsBlocked) {
  Grid grid = free_grid(6.0);
  occupy(grid, [](double x, double y) { return x > 0.5 && x < 0.55 && std::abs(y) < 0.05; });
  const Filtered out = once({0.8, 0.4}, at(0.5 - kBumper - 0.026), as_map(std::move(grid)));
  EXPECT_EQ(out.reason, FilterReason::kDeflected);
  EXPECT_EQ(out.twist.v, 0.0);
  EXPECT_GT(out.twist.w, 0.05);
}

TEST(SafetyFilter, BacksOutFromInsideTheMargin) {
  const RobotState state = facing_wall(0.01);
  EXPECT_EQ(once({0.8, 0.0}, state).twist, Twist2{});
  const Filtered out = once({-0.4, 0.0}, state);
  EXPECT_EQ(out.reason, FilterReason::kBackingOut);
  EXPECT_EQ(out.twist, (Twist2{-0.4, 0.0}));
  const Filtered arc = once({-0.4, 0.3}, state);  // would swing a corner if v came later than w
  EXPECT_EQ(arc.reason, FilterReason::kDeflected);
  EXPECT_EQ(arc.twist, (Twist2{-0.4, 0.0}));
}

// Two walls nearer than the margin: while leaving one, the robot must not get closer to the other
// than that one is.
TEST(SafetyFilter, InsideTheMarginOfOneWallItKeepsTheMarginToAnother) {
  Grid grid = free_grid(6.0);
  occupy(grid, [](double x, double) { return x > 1.5 || x < 0.55; });  // 0.95 m for 0.89 m
  const auto map = as_map(std::move(grid));
  const double behind = 0.55 - 0.038 + 0.445;  // base_link, the rear at the wall behind
  const Filtered out = once({0.4, 0.0}, at(behind + 0.005), map);
  EXPECT_GT(out.twist.v, 0.0);
  const double rest = 0.95 - 0.89 - 0.005;  // to the wall ahead
  EXPECT_LT(out.twist.v * 0.16, rest - 0.0247) << "by hold, delays and lag alone";
}

TEST(SafetyFilter, InAGapNarrowerThanTwoMarginsItLeavesNeitherWallForTheOther) {
  Grid grid = free_grid(6.0);
  occupy(grid, [](double x, double) { return x > 1.5 || x < 0.6; });  // 0.90 m for 0.89 m
  const auto map = as_map(std::move(grid));
  const double behind = 0.6 - 0.038 + 0.445;
  for (const double v : {0.8, 0.05, -0.4})
    EXPECT_EQ(once({v, 0.0}, at(behind + 0.002), map).twist, Twist2{}) << v;
}

TEST(SafetyFilter, BacksOutOfAMeasuredContact) {
  const RobotState state = facing_wall(-0.02);
  EXPECT_EQ(once({0.8, 0.0}, state).twist, Twist2{});
  EXPECT_EQ(once({0.1, 0.0}, state).twist, Twist2{});
  EXPECT_EQ(once({-0.4, 0.0}, state).twist, (Twist2{-0.4, 0.0}));
}

TEST(SafetyFilter, StopsWithoutACommandAMapOrAPose) {
  SafetyFilter filter(SafetyFilterParams{}, kMir);
  EXPECT_EQ(filter.update(at(-2.0), 0.0).reason, FilterReason::kNoCommand);
  filter.on_command({0.5, 0.0}, 0.0);
  EXPECT_EQ(filter.update(at(-2.0), 0.0).reason, FilterReason::kNoMap);
  filter.on_map(wall_ahead());
  EXPECT_EQ(filter.update(std::nullopt, 0.0).reason, FilterReason::kNotLocalized);
  EXPECT_EQ(filter.update(std::nullopt, 0.0).twist, Twist2{});
  // NaN, not zero: it was not computed
  EXPECT_TRUE(std::isnan(filter.update(std::nullopt, 0.0).clearance));
  EXPECT_EQ(filter.update(at(-2.0), 0.0).reason, FilterReason::kClear);
  EXPECT_EQ(filter.update(at(-2.0), 0.16).reason, FilterReason::kNoCommand);
  EXPECT_EQ(filter.update(at(-2.0), 0.16).twist, Twist2{});
}

TEST(SafetyFilter, StopsOnAStaleState) {
  SafetyFilter filter = filter_on(wall_ahead());
  filter.on_command({0.5, 0.0}, 1.0);
  const Filtered out = filter.update(at(-2.0), 1.0);  // measured at 0
  EXPECT_EQ(out.reason, FilterReason::kNotLocalized);
  EXPECT_EQ(out.twist, Twist2{});
}

TEST(SafetyFilter, StandsWhenThePoseJumpsAndAcceptsItOnlyAfterAWhile) {
  SafetyFilter filter = filter_on(wall_ahead());
  const auto drive = [&](double x, double theta, double now) {
    filter.on_command({0.5, 0.0}, now);
    return filter.update(RobotState{{x, 0.0, theta}, {0.5, 0.0}, now}, now);
  };
  double now = 0.0, x = -3.0;
  for (; now < 1.0; now += 0.05, x += 0.025)
    EXPECT_EQ(drive(x + (now > 0.5 ? 0.1 : 0.0), 0.0, now).reason, FilterReason::kClear);
  for (const auto& [dx, turn] : {std::pair{0.4, 0.0}, std::pair{0.0, 0.5}}) {  // too far, too wide
    x += dx;
    const double jumped = now;
    for (; now < jumped + 0.99; now += 0.05, x += 0.025) {
      const Filtered out = drive(x, turn, now);
      EXPECT_EQ(out.reason, FilterReason::kPoseJumped);
      EXPECT_EQ(out.twist, Twist2{});
    }
    now = jumped + 1.05;
    x += 0.0025;
    EXPECT_EQ(drive(x, turn, now).reason, FilterReason::kClear);
    now += 0.05;
    x += 0.025;
  }
}

// Another robot's pose arrives after each of this robot's: both are received between two commands,
// so successive latest poses never differ much.
TEST(SafetyFilter, StandsWhileTwoPublishersGiveDifferentPosesBetweenItsCommands) {
  SafetyFilter filter = filter_on(wall_ahead());
  const auto at_y = [](double y, double now) { return RobotState{{-3.0, y, 0.0}, {}, now}; };
  for (double now = 0.0; now < 5.0; now += 0.05) {
    filter.on_state(at_y(0.0, now), now);
    filter.on_state(at_y(2.0, now), now);
    filter.on_command({0.5, 0.0}, now);
    EXPECT_EQ(filter.update(at_y(2.0, now), now).reason, FilterReason::kPoseJumped);
  }
}

TEST(SafetyFilter, AJumpDuringASilenceCountsAsAJump) {
  SafetyFilter filter = filter_on(wall_ahead());
  const auto driven_from = [&](double before, double v, double after) {
    filter.on_state({{before, 0.0, 0.0}, {v, 0.0}, 0.0}, 0.0);
    filter.on_command({0.5, 0.0}, 1.0);
    return filter.update(RobotState{{after, 0.0, 0.0}, {}, 1.0}, 1.0).reason;
  };
  EXPECT_EQ(driven_from(-4.0, 0.0, -3.0), FilterReason::kPoseJumped);
  filter = filter_on(wall_ahead());
  EXPECT_EQ(driven_from(-4.0, 0.8, -3.5), FilterReason::kClear);  // it came to rest there
}

TEST(SafetyFilter, AfterAClockResetOldCommandsAndDoubtsAreForgotten) {
  SafetyFilter filter = filter_on(wall_ahead());
  const auto driven = [&](double x, double now) {
    filter.on_command({0.5, 0.0}, now);
    return filter.update(RobotState{{x, 0.0, 0.0}, {}, now}, now).reason;
  };
  EXPECT_EQ(driven(-3.0, 60.0), FilterReason::kClear);
  EXPECT_EQ(driven(-2.0, 60.05), FilterReason::kPoseJumped);  // for a second from then on
  const RobotState state{{-3.0, 0.0, 0.0}, {}, 0.0};
  filter.on_time_jump(0.0);
  EXPECT_EQ(filter.update(state, 0.0).reason, FilterReason::kNoCommand);
  EXPECT_EQ(driven(-3.0, 0.5), FilterReason::kPoseJumped);
  EXPECT_EQ(driven(-3.0, 1.05), FilterReason::kClear);
}

TEST(SafetyFilter, RefusesNonFiniteInputs) {
  for (const Twist2 command : {Twist2{kNaN, 0.0}, Twist2{0.1, kNaN}, Twist2{kInf, 0.0}}) {
    EXPECT_EQ(once(command, at(-2.0)).reason, FilterReason::kNotFinite);
    EXPECT_EQ(once(command, at(-2.0)).twist, Twist2{});
  }
  EXPECT_EQ(once({0.1, 0.0}, at(kNaN)).twist, Twist2{});
  EXPECT_EQ(once({0.1, 0.0}, at(-2.0, 0.0, 0.0, {kNaN, 0.0})).twist, Twist2{});
}

TEST(SafetyFilter, OnlyReportsWhileNotEnforcing) {
  SafetyFilter filter = filter_on(wall_ahead(), {.enforce = false});
  filter.on_command({0.8, 0.0}, 0.0);
  const Filtered out = filter.update(facing_wall(0.05), 0.0);
  EXPECT_EQ(out.twist, (Twist2{0.8, 0.0}));
  EXPECT_LT(out.safe.v, 0.2);
  EXPECT_EQ(out.reason, FilterReason::kSlowed);
  // missing commands still stop the robot
  EXPECT_EQ(filter.update(facing_wall(0.05), 0.2).twist, Twist2{});
  filter.on_command({kNaN, 0.0}, 0.3);
  EXPECT_EQ(filter.update(facing_wall(0.05), 0.3).twist, Twist2{});
}

// A stop that the node commands counts as a command: once it acts, the previous one no longer does.
TEST(SafetyFilter, AStopOfItsNodeCountsAsSent) {
  const auto backs_out = [](bool stops) {
    SafetyFilter filter = filter_on(wall_ahead());
    filter.on_command({0.8, 0.0}, 0.0);
    EXPECT_GT(filter.update(facing_wall(1.0), 0.0).twist.v, 0.0);
    if (stops) {
      EXPECT_EQ(filter.stop(FilterReason::kClockSilent, 0.05).twist, Twist2{});
    }
    RobotState state;
    for (double gap = 1.0; gap > 0.0; gap -= 0.12) {  // the poses it passed meanwhile
      state = facing_wall(gap);
      state.t = 1.0 - gap + 0.04;
      filter.on_state(state, state.t);
    }
    filter.on_command({-0.4, 0.0}, 1.0);
    return filter.update(state, 1.0).twist.v < 0.0;
  };
  EXPECT_TRUE(backs_out(true));
  EXPECT_FALSE(backs_out(false));  // it may still be on its way ahead
}

TEST(SafetyFilterParams, SurvivesNoSilenceOnABaseThatNeverStops) {
  RobotParams robot;
  robot.base_timeout = 0.0;
  EXPECT_THROW(SafetyFilter({}, robot), std::invalid_argument);
  EXPECT_NO_THROW(SafetyFilter({.survive_silence = false}, robot));
}

TEST(SafetyFilterParams, RejectsAParameterOutsideItsRange) {
  EXPECT_THROW(SafetyFilter({.slip = -0.1}, kMir), std::invalid_argument);
  RobotParams robot;
  robot.a_brake = 0.0;
  EXPECT_THROW(SafetyFilter({}, robot), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::test
