// SPDX-License-Identifier: Apache-2.0
// Every component's core in one loop, in the shipped scenarios: reaches, avoids, stops. A few
// seeds; all twenty: `tandem scenario bringup/scenarios/*.yaml --lockstep --method all --seeds
// 1-20`.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bringup/drive/lockstep.hpp"
#include "support/paths.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/map/virtual_fixtures.hpp"

namespace tandem {
namespace {

constexpr unsigned kSeeds = 3;

const auto kOpen = ::testing::Values("forest_task2", "corridor", "slalom");
const auto kNarrow = ::testing::Values("clutter", "ward", "doorway");
const auto kMethods = ::testing::Values("leader", "intention", "path", "blend");

std::string file(const std::string& name) {
  return test::source_path("bringup/scenarios/" + name + ".yaml");
}

DriveResult drive(const std::string& path, const std::string& method, unsigned seed,
                  bool enforce = true) {
  const DriveOptions options{.method = method, .seed = seed, .enforce = enforce, .lockstep = true};
  return drive_in_lockstep(load_scenario(path), options).result;
}

double changed_share(const DriveResult& result) {
  return static_cast<double>(result.counts.filter_interventions) /
         static_cast<double>(result.counts.filter_commands);
}

class Shipped : public ::testing::TestWithParam<std::tuple<const char*, const char*>> {};

TEST_P(Shipped, ReachesItsGoalWithoutContact) {
  const auto [scenario, method] = GetParam();
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const DriveResult result = drive(file(scenario), method, seed);
    EXPECT_TRUE(result.reached) << "seed " << seed;
    EXPECT_EQ(result.collisions, 0) << "seed " << seed;
    EXPECT_GT(result.min_clearance_m, 0.0) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Shipped, ::testing::Combine(kOpen, kMethods),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) + "_" +
                                  std::get<1>(test.param);
                         });

INSTANTIATE_TEST_SUITE_P(ByThePersonBehindTheFilter, Shipped,
                         ::testing::Combine(kOpen, ::testing::Values("safety_filter")),
                         [](const auto& test) { return std::string(std::get<0>(test.param)); });

class Planned : public ::testing::TestWithParam<std::tuple<const char*, const char*>> {};

// Where the person alone, even behind the filter, collides or does not get through.
TEST_P(Planned, ReachesItsGoalWithoutContact) {
  const auto [scenario, method] = GetParam();
  const DriveResult result = drive(file(scenario), method, 1);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.collisions, 0);
  EXPECT_LT(result.stuck_s, 5.0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Planned, ::testing::Combine(kNarrow, kMethods),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) + "_" +
                                  std::get<1>(test.param);
                         });

// Three who came before the door askew, and danced there for two minutes.
TEST(Doorway, IsPassedAfterATryInVain) {
  const std::pair<const char*, unsigned> drives[] = {{"path", 34}, {"path", 22}, {"leader", 22}};
  for (const auto& [method, seed] : std::span(drives).first(kSeeds)) {
    const DriveResult result = drive(file("doorway"), method, seed);
    EXPECT_TRUE(result.reached) << method << ", seed " << seed;
    EXPECT_EQ(result.collisions, 0) << method << ", seed " << seed;
  }
}

// Two of the six places are on the two sides of one bed-room.
TEST(Hindsight, BringsAPersonToEachPlaceWithoutContact) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const DriveResult result = drive(file("ward_goals"), "hindsight", seed);
    EXPECT_TRUE(result.reached) << "place " << seed;
    EXPECT_EQ(result.collisions, 0) << "place " << seed;
  }
}

int turns_back(const DriveLog& log) {
  int count = 0;
  double turn = 0.0;
  for (const DriveSample& sample : log.track) {
    if (std::abs(sample.twist.w) < 0.1) continue;
    count += turn * sample.twist.w < 0.0 ? 1 : 0;
    turn = sample.twist.w;
  }
  return count;
}

class Delayed : public ::testing::TestWithParam<const char*> {};

// 0.3 s of delay and lag: neither contact nor oscillation beside the same drives with 0.09 s.
TEST_P(Delayed, ForestIsDrivenAsCalmlyAsWithoutTheDelay) {
  double quick_way = 0.0, slow_way = 0.0;
  int quick_turns = 0, slow_turns = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const DriveOptions options{.method = GetParam(), .seed = seed, .lockstep = true};
    const DriveLog quick = drive_in_lockstep(load_scenario(file("forest_task2")), options);
    const DriveLog slow = drive_in_lockstep(load_scenario(file("forest_delay")), options);
    EXPECT_TRUE(slow.result.reached);
    EXPECT_EQ(slow.result.collisions, 0);
    quick_way += quick.result.path_length_m;
    slow_way += slow.result.path_length_m;
    quick_turns += turns_back(quick);
    slow_turns += turns_back(slow);
  }
  EXPECT_LT(slow_way, 1.1 * quick_way);
  EXPECT_LE(slow_turns, quick_turns + 6 * static_cast<int>(kSeeds));
}

INSTANTIATE_TEST_SUITE_P(Methods, Delayed,
                         ::testing::Values("leader", "intention", "path", "blend"),
                         [](const auto& test) { return std::string(test.param); });

// Motors of 0.4 s: a planner that knows the lag arrives sooner and leaves less to the filter.
TEST(MotorLag, ToldToThePlannerSparesTheFilter) {
  double told_time = 0.0, untold_time = 0.0, told_changes = 0.0, untold_changes = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Scenario scenario = load_scenario(file("forest_lag"));
    const DriveOptions options{.method = "leader", .seed = seed, .lockstep = true};
    const DriveResult told = drive_in_lockstep(scenario, options).result;
    EXPECT_TRUE(told.reached);
    EXPECT_EQ(told.collisions, 0);
    for (const char* lag : {"lag_v", "lag_w"})
      scenario.parameters["local_planner"][lag] = {"0.0", "this test"};
    const DriveResult untold = drive_in_lockstep(scenario, options).result;
    told_time += told.time_to_goal_s;
    untold_time += untold.reached ? untold.time_to_goal_s : untold.simulated_s;
    told_changes += changed_share(told);
    untold_changes += changed_share(untold);
  }
  EXPECT_LT(told_time, untold_time);
  EXPECT_LT(told_changes, 0.7 * untold_changes);
}

// A few worlds across the file; all 150: `tandem scenario tests/closed_loop/barn.yaml --lockstep
// --method all --seeds 1-150`.
TEST(Barn, WorldsArePassedWithoutContact) {
  const std::string worlds = test::shared_path("barn/worlds.json");
  if (!std::filesystem::exists(worlds)) GTEST_SKIP() << worlds << " is not here";
  const std::string path = test::source_path("tests/closed_loop/barn.yaml");
  for (const unsigned seed : {20U, 70U, 110U, 150U}) {
    const DriveOptions options{.method = "leader", .seed = seed, .map = worlds, .lockstep = true};
    const DriveResult result = drive_in_lockstep(load_scenario(path), options).result;
    EXPECT_TRUE(result.reached) << result.map;
    EXPECT_EQ(result.collisions, 0) << result.map;
  }
}

class Forbidden : public ::testing::TestWithParam<const char*> {};

// The region is no obstacle to the simulator: only planner and filter keep the robot out.
TEST_P(Forbidden, RegionsAreNeverEntered) {
  const std::string folder = test::source_path("tests/closed_loop/");
  const VirtualFixtures fixtures = load_virtual_fixtures(folder + "forest_mat.yaml");
  const Grid empty{0.02, {-5.0, -5.0}, 500, 500, std::vector<Cell>(250000, Cell::kFree)};
  const StaticMap region{with_forbidden(empty, fixtures)};
  const Footprint mir = rectangle(0.89, 0.58, 0.038);
  const DriveOptions options{.method = GetParam(), .seed = 2, .lockstep = true};
  const DriveLog log = drive_in_lockstep(load_scenario(folder + "forest_forbidden.yaml"), options);
  EXPECT_TRUE(log.result.reached);
  double nearest = 1.0;
  for (const DriveSample& sample : log.track)
    nearest = std::min(nearest, region.clearance(mir, sample.X_MB, 1.0));
  EXPECT_GT(nearest, 0.0);
  EXPECT_LT(nearest, 0.5) << "the way leads past it, else this proves nothing";
}

// Obstacles are known only from the laser scanner.
class WithoutAMap : public ::testing::TestWithParam<const char*> {};

TEST_P(WithoutAMap, ReachesItsGoalWithoutContact) {
  const DriveResult result =
      drive(test::source_path("tests/closed_loop/forest_unknown.yaml"), GetParam(), 1);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.collisions, 0);
}

INSTANTIATE_TEST_SUITE_P(Methods, WithoutAMap, ::testing::Values("safety_filter", "leader"),
                         [](const auto& test) { return std::string(test.param); });

INSTANTIATE_TEST_SUITE_P(Methods, Forbidden,
                         ::testing::Values("safety_filter", "leader", "intention"),
                         [](const auto& test) { return std::string(test.param); });

class AmongPeople : public ::testing::TestWithParam<const char*> {};

// People walk through everything, even into the robot, but contact is allowed only while it stands.
TEST_P(AmongPeople, ReachesItsGoalAndTouchesNobody) {
  const DriveResult result = drive(file("crossing"), GetParam(), 1);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.collisions, 0);
}

INSTANTIATE_TEST_SUITE_P(Methods, AmongPeople, ::testing::Values("safety_filter", "leader"),
                         [](const auto& test) { return std::string(test.param); });

TEST(ForestTask1, LeaderDrivesTwoMinutesWithoutContact) {
  const DriveResult result = drive(file("forest_task1"), "leader", 1);
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.collisions, 0);
  EXPECT_GE(result.path_length_m, 30.0);
}

class Manual : public ::testing::TestWithParam<const char*> {};

// Otherwise the driver proves nothing.
TEST_P(Manual, CollidesInSomeOfTwentySeeds) {
  int collided = 0;
  for (unsigned seed = 1; seed <= 20 && collided == 0; ++seed)
    collided += drive_in_lockstep(load_scenario(file(GetParam())),
                                  {.method = "manual", .seed = seed, .lockstep = true})
                            .result.collisions > 0
                    ? 1
                    : 0;
  EXPECT_GT(collided, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Manual,
                         ::testing::Values("forest_task1", "forest_task2", "corridor", "crossing"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Planner, AvoidsObstaclesAloneAndTheFilterSeldomIntervenes) {
  for (const char* method : {"leader", "intention"}) {
    const DriveResult alone = drive(file("forest_task2"), method, 1, false);
    EXPECT_EQ(alone.collisions, 0) << method;
    EXPECT_LE(changed_share(alone), 0.01) << method;
  }
}

TEST(Tables, SteadyStateErrorsAreComparedWithTheThesis) {
  for (const auto& [name, thesis] : {std::pair{"table_3_1", 0.1283}, {"table_3_2", 0.1142}}) {
    const DriveResult result = drive(file(name), "goal", 1);
    std::printf("%s: steady-state error %.4f m (thesis %.4f m), path %.2f m\n", name,
                result.final_position_error_m, thesis, result.path_length_m);
    EXPECT_EQ(result.collisions, 0) << name;
    EXPECT_LT(result.final_position_error_m, 0.25) << name;
  }
}

class RealBuilding : public ::testing::TestWithParam<const char*> {};

TEST_P(RealBuilding, JackalReachesItsGoalWithoutContact) {
  const std::string map = test::shared_path("maps/geb079.bt");
  if (!std::filesystem::exists(map)) GTEST_SKIP() << map << " is not here";
  const std::string path =
      test::source_path("tests/closed_loop/" + std::string(GetParam()) + ".yaml");
  const DriveOptions options{.method = "leader", .seed = 1, .map = map, .lockstep = true};
  const DriveResult result = drive_in_lockstep(load_scenario(path), options).result;
  EXPECT_TRUE(result.reached);
  EXPECT_EQ(result.collisions, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, RealBuilding,
                         ::testing::Values("geb079_corridor", "geb079_room_1", "geb079_room_2"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace tandem
