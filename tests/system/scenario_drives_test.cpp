// SPDX-License-Identifier: Apache-2.0
// Runs scenarios over DDS with the program, as a user does: their expectations hold, and the
// planner meets its deadlines.
#include "system/scenario_program.hpp"

namespace tandem::test {
namespace {

constexpr double kBudget = 35.0;  // [ms] of a planning cycle, the default

TEST_F(ScenarioProgram, LeaderReachesTheRegionOverDds) {
  ASSERT_EQ(run("forest_task2", {"--dds", "--picture", folder_.string()}), 0);
  const auto drive = json().at(0);
  EXPECT_EQ(drive.at("reached"), true);
  EXPECT_EQ(drive.at("collisions"), 0);
  EXPECT_EQ(drive.at("lockstep"), false);
  EXPECT_GT(drive.at("plan_ms").at("p50"), 0.0);
  EXPECT_GT(std::filesystem::file_size(folder_ / "forest_task2_leader_1.png"), 10'000u);
}

struct Drive {
  const char *scenario, *method, *speed;
};

// Runs one seed of each scenario with the real nodes, some faster than real time by /clock.
class OverDds : public ScenarioProgram, public ::testing::WithParamInterface<Drive> {};

TEST_P(OverDds, HoldsWhatTheScenarioExpects) {
  const Drive& drive = GetParam();
  ASSERT_EQ(run(drive.scenario, {"--dds", "--method", drive.method, "--speed", drive.speed}), 0);
  const auto result = json().at(0);
  EXPECT_EQ(result.at("collisions"), 0);
  if (result.at("plans") == 0) return;
  EXPECT_LE(result.at("plan_fallbacks").get<double>(), 0.01 * result.at("plans").get<double>());
  // Wall-clock time: the machine may take the processor away from a solve now and then.
  EXPECT_LE(result.at("plan_overruns").get<double>(), 0.002 * result.at("plans").get<double>());
  EXPECT_LE(result.at("plan_ms").at("p99").get<double>(), kBudget);
}

#if defined(__SANITIZE_ADDRESS__)  // slow code misses its deadlines: only that it drives
INSTANTIATE_TEST_SUITE_P(Sanitized, OverDds,
                         ::testing::Values(Drive{"corridor", "safety_filter", "1"}),
                         [](const auto&) { return "corridor"; });
#else
INSTANTIATE_TEST_SUITE_P(
    Scenarios, OverDds,
    ::testing::Values(Drive{"forest_task2", "intention", "1"}, Drive{"forest_task2", "blend", "2"},
                      Drive{"forest_task1", "leader", "4"}, Drive{"corridor", "leader", "1"},
                      Drive{"corridor", "safety_filter", "2"}, Drive{"slalom", "leader", "2"},
                      Drive{"table_3_1", "goal", "4"}, Drive{"table_3_2", "goal", "4"}),
    [](const auto& test) { return std::string(test.param.scenario) + "_" + test.param.method; });
#endif

TEST_F(ScenarioProgram, OtherMethodsAndDriversDriveOverDds) {
  const std::pair<const char*, const char*> drives[] = {{"dwa", "navigator+tremor"},
                                                        {"adaptive", "pointer+dropouts"}};
  for (const auto& [method, driver] : drives) {
    EXPECT_EQ(
        run("forest_task2", {"--dds", "--method", method, "--driver", driver, "--speed", "2"}), 0)
        << method;
    const auto drive = json().at(0);
    EXPECT_EQ(drive.at("collisions"), 0) << method;
    EXPECT_EQ(drive.at("driver"), driver);
    EXPECT_GT(drive.at("plans"), 50) << method;
  }
}

TEST_F(ScenarioProgram, HindsightDrivesOverDdsThroughANodeOfItsOwn) {
  ASSERT_EQ(run("ward_goals", {"--dds", "--seed", "6", "--speed", "2"}), 0);
  const auto drive = json().at(0);
  EXPECT_EQ(drive.at("collisions"), 0);
  EXPECT_GT(drive.at("plans"), 50);
}

}  // namespace
}  // namespace tandem::test
