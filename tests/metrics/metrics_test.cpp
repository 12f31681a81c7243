// SPDX-License-Identifier: Apache-2.0
// Tests the measures on drives whose results can be calculated by hand.
#include "tandem/metrics/metrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

namespace tandem {
namespace {

constexpr double kTick = 0.01;
const MetricsSetting kSetting{
    .goal = RegionGoal{{0.99, -1.0}, {9.0, 1.0}}, .v_max = 1.0, .w_max = 2.0, .shortest_path = 0.8};

// The measures of a drive of `seconds` whose samples come from `at`.
DriveResult measure(double seconds, const std::function<DriveSample(double)>& at,
                    const MetricsSetting& setting = kSetting) {
  Metrics metrics{setting};
  for (long n = 0; n <= std::lround(seconds / kTick); ++n) {
    const double t = kTick * static_cast<double>(n);
    DriveSample sample = at(t);
    sample.t = t;
    metrics.add(sample);
  }
  DriveResult result;
  metrics.write(result);
  return result;
}

DriveSample steady(const Twist2& user, const Twist2& robot, double clearance = 1.0) {
  return {.twist = robot, .user = user, .clearance = clearance};
}

TEST(Metrics, OfADriveThatFollowsTheCommand) {
  const auto r = measure(2.0, [](double t) {
    DriveSample sample = steady({0.5, 0.0}, {0.5, 0.0});
    sample.X_MB.x = 0.5 * t;
    return sample;
  });
  EXPECT_TRUE(r.reached);
  EXPECT_NEAR(r.time_to_goal_s, 1.98, 1e-9);
  EXPECT_NEAR(r.path_length_m, 1.0, 1e-12);
  EXPECT_NEAR(r.path_ratio.value(), 1.0 / 0.8, 1e-12);
  EXPECT_EQ(r.obedience_rms, 0.0);
  EXPECT_NEAR(r.agreement_direction.value(), 1.0, 1e-12);
  EXPECT_NEAR(r.agreement_magnitude.value(), 1.0, 1e-12);
  EXPECT_NEAR(r.jerk_rms.value(), 0.0, 1e-9);
  EXPECT_EQ(r.stuck_s, 0.0);
  EXPECT_EQ(r.stick_travel_per_s, 0.0);
  EXPECT_EQ(r.stick_reversals, 0);
}

TEST(Metrics, HasNoPathRatioForADriveThatDidNotArrive) {
  const auto r = measure(1.0, [](double) { return steady({0.5, 0.0}, {0.5, 0.0}); });
  EXPECT_FALSE(r.reached);
  EXPECT_FALSE(r.path_ratio.has_value());
}

TEST(Metrics, AgreementComparesDirectionsInSharesOfTheLimits) {
  // (0.5, 0.5) of the limits against (0.5, 0): 45°, and 1/√2 as much.
  const auto r = measure(1.0, [](double) { return steady({0.5, 1.0}, {0.5, 0.0}); });
  EXPECT_NEAR(r.agreement_direction.value(), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(r.agreement_magnitude.value(), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(r.obedience_rms, std::sqrt(0.125), 1e-12);
}

TEST(Metrics, AgreementIsMinusOneForTheOppositeAndUndefinedForAPersonAtRest) {
  EXPECT_NEAR(measure(1.0,
                      [](double) {
                        return steady({0.5, 0.0}, {-0.2, 0.0});
                      })
                  .agreement_direction.value(),
              -1.0, 1e-12);
  const auto rests = measure(1.0, [](double) { return steady({}, {0.5, 0.0}); });
  EXPECT_FALSE(rests.agreement_direction.has_value());
  EXPECT_FALSE(rests.agreement_magnitude.has_value());
}

TEST(Metrics, AgreementInTheFreeCountsWhereNothingIsNear) {
  const auto r = measure(2.0, [](double t) {
    return t <= 1.0 ? steady({0.5, 0.0}, {-0.5, 0.0}, 0.49) : steady({0.5, 0.0}, {0.5, 0.0}, 0.5);
  });
  EXPECT_NEAR(r.agreement_direction_free.value(), 1.0, 1e-12);
  EXPECT_NEAR(r.agreement_direction.value(), 0.0, 1e-9);
}

TEST(Metrics, ARobotThatStandsWhileThePersonPushesIsStuck) {
  const auto r = measure(3.0, [](double t) { return steady({t < 1.0 ? 0.0 : 0.5, 0.0}, {}); });
  EXPECT_NEAR(r.stuck_s, 2.01, 1e-9);  // the sample at 1 s ends the step before it
  EXPECT_FALSE(r.agreement_direction.has_value());
  EXPECT_EQ(r.agreement_magnitude.value(), 0.0);
}

TEST(Metrics, ClearanceIsItsMinimumAndItsMeanUpToOneMetre) {
  const auto r = measure(2.0, [](double t) { return steady({}, {}, t <= 1.0 ? 0.2 : 5.0); });
  EXPECT_EQ(r.min_clearance_m, 0.2);
  EXPECT_NEAR(r.mean_clearance_m, 0.6, 1e-12);
}

TEST(Metrics, StickTravelsAndReverses) {
  // Every half second from one side to the other by the whole range: 2 of the limit, 7 times.
  const auto r = measure(3.99, [](double t) {
    return steady({0.0, static_cast<int>((t + 1e-9) / 0.5) % 2 == 0 ? 2.0 : -2.0}, {});
  });
  EXPECT_EQ(r.stick_reversals, 7);
  EXPECT_NEAR(r.stick_travel_per_s, 14.0 / 3.99, 1e-9);
}

TEST(Metrics, SmallTurnsOfTheStickAreNoReversals) {
  const auto r = measure(2.0, [](double t) {
    return steady({0.5, std::fmod(t, 0.2) < 0.1 ? 0.15 : -0.15}, {});
  });
  EXPECT_EQ(r.stick_reversals, 0);
}

TEST(Metrics, LeavesOutASampleFromThePast) {
  Metrics metrics{kSetting};
  for (const double t : {1.0, 2.0, 0.5, 3.0}) {
    DriveSample sample;
    sample.t = t;
    sample.X_MB.x = t == 0.5 ? -100.0 : 0.1 * t;
    metrics.add(sample);
  }
  DriveResult r;
  metrics.write(r);
  EXPECT_NEAR(r.path_length_m, 0.2, 1e-12);
  EXPECT_NEAR(r.simulated_s, 2.0, 1e-12);
}

TEST(Metrics, RoamingHasNoPlaceToReach) {
  const auto r = measure(2.0,
                         [](double t) {
                           DriveSample sample = steady({0.5, 0.0}, {0.5, 0.0});
                           sample.X_MB.x = 0.5 * t;
                           return sample;
                         },
                         {.goal = RoamGoal{2.0, 0.9}, .v_max = 1.0, .w_max = 1.0});
  EXPECT_TRUE(r.reached);
  EXPECT_FALSE(r.path_ratio.has_value());
  EXPECT_EQ(r.final_position_error_m, 0.0);
}

// Drives to x = 1 m and stands there; the heading is `askew`.
DriveResult arrive(const PoseGoal& goal, double askew,
                   const std::optional<RegionGoal>& after = {}) {
  return measure(
      6.0,
      [&](double t) {
        DriveSample sample = steady({t < 2.0 ? 0.5 : 0.0, 0.0}, {t < 2.0 ? 0.5 : 0.0, 0.0});
        sample.X_MB = {std::min(0.5 * t, 1.0), 0.0, askew};
        return sample;
      },
      {.goal = goal, .after = after});
}

TEST(Metrics, APoseMayBeReachedOnlyBySomeHeadingsAndStanding) {
  const PoseGoal goal{
      .X_MG = {1.0, 0.03, 0.2}, .tolerance = 0.05, .heading_tolerance = 0.1, .stand = 3.0};
  const auto r = arrive(goal, 0.15);
  EXPECT_TRUE(r.reached);
  EXPECT_NEAR(r.time_to_goal_s, 2.0, 0.011);  // when it came to rest, not when it had stood
  EXPECT_NEAR(r.final_position_error_m, 0.03, 1e-9);
  EXPECT_NEAR(r.final_heading_error_rad.value(), 0.05, 1e-9);
  EXPECT_FALSE(arrive(goal, 0.0).reached);
  EXPECT_FALSE(arrive({.X_MG = {1.0, 0.0, 0.0}, .tolerance = 0.05, .stand = 5.0}, 0.0).reached);
}

TEST(Metrics, AGoalMayCountOnlyAfterAnotherPlace) {
  const PoseGoal goal{.X_MG = {1.0, 0.0, 0.0}, .tolerance = 0.05};
  EXPECT_TRUE(arrive(goal, 0.0, RegionGoal{{0.4, -1.0}, {0.6, 1.0}}).reached);
  EXPECT_FALSE(arrive(goal, 0.0, RegionGoal{{2.0, -1.0}, {3.0, 1.0}}).reached);
}

TEST(Metrics, TheWayToRestIsTheFarthestAfterTheStickCameToRest) {
  // Pushed for 1 s and rolling on for 0.1 s, then pushed again and rolling on for 0.3 s.
  const auto r = measure(6.0, [](double t) {
    const bool pushes = t < 1.0 || (t >= 3.0 && t < 4.0);
    const bool rolls = pushes || t < 1.1 || (t >= 4.0 && t < 4.3);
    DriveSample sample = steady({pushes ? 0.5 : 0.0, 0.0}, {rolls ? 0.5 : 0.0, 0.0});
    sample.X_MB.x = 0.5 * (std::min(t, 1.1) + std::clamp(t - 3.0, 0.0, 1.3));
    return sample;
  });
  EXPECT_NEAR(r.way_to_rest_m.value(), 0.15, 0.006);
  const auto pushed = measure(1.0, [](double) { return steady({0.5, 0.0}, {0.5, 0.0}); });
  EXPECT_FALSE(pushed.way_to_rest_m.has_value());
}

TEST(Metrics, TravelIsReversedByDrivingTheOtherWay) {
  // Forward, a rocking too slow to count, forward, backward, stop, backward, forward.
  const auto r = measure(7.0, [](double t) {
    const double v[] = {0.5, -0.04, 0.5, -0.3, 0.0, -0.3, 0.2, 0.2};
    return steady({}, {v[static_cast<int>(t)], 0.0}, 0.4);
  });
  EXPECT_EQ(r.travel_reversals, 2);
  EXPECT_EQ(r.final_clearance_m, 0.4);
}

TEST(DriveCounts, CountsInterventionsAndUnbrokenRunsOfThem) {
  DriveCounts counts;
  double t = 0.0;
  for (const bool changed : {false, true, true, false, true, false, false})
    counts.on_filtered(t += DriveCounts::kFilterLook, changed);
  EXPECT_EQ(counts.filter_commands, 7);
  EXPECT_EQ(counts.filter_interventions, 3);
  EXPECT_EQ(counts.filter_episodes, 2);
}

TEST(DriveCounts, UsesTheFirstStatusOfEachPeriod) {
  DriveCounts counts;
  for (int n = 1; n <= 1000; ++n) counts.on_filtered(0.01 * n, n % 5 == 0);
  EXPECT_EQ(counts.filter_commands, 201);
  EXPECT_EQ(counts.filter_interventions, 200);  // those at 0.05, 0.10 …
}

TEST(Metrics, APlanLongerThanTheControlPeriodMissesItsDeadline) {
  DriveResult r;
  r.counts.plan_ms = {10.0, 60.0, 50.0, 50.1};
  Metrics{kSetting}.write(r);
  EXPECT_EQ(r.missed_deadlines, 2);
  EXPECT_EQ(r.plan_ms.p50, 50.0);
  EXPECT_EQ(r.plan_ms.max, 60.0);
}

TEST(DriveResult, ComesBackFromItsJson) {
  auto r = measure(1.0, [](double t) { return steady({0.5, std::sin(t)}, {0.4, 0.0}); });
  r.scenario = "s";
  r.failures = {"a", "b"};
  const nlohmann::json json = r;
  EXPECT_TRUE(json.at("path_ratio").is_null());
  const nlohmann::json again = nlohmann::json::parse(json.dump()).get<DriveResult>();
  EXPECT_EQ(again, json);
}

}  // namespace
}  // namespace tandem
