// SPDX-License-Identifier: Apache-2.0
// Runs scenarios over DDS with the program, as a user does: their expectations hold, and the
// planner meets its deadlines.
#include <sys/resource.h>

#include "support/busy_machine.hpp"
#include "system/scenario_program.hpp"

namespace tandem::test {
namespace {

constexpr double kBudget = 35.0;  // [ms] of a planning cycle, the default

TEST_F(ScenarioProgram, LeaderReachesTheRegionOverDds) {
  ASSERT_EQ(run("forest_task2", {"--dds", "--speed", "2", "--picture", folder_.string()}), 0);
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

// [s] processor time of the child processes that have ended.
double time_of_children() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

TEST_P(OverDds, HoldsWhatTheScenarioExpects) {
  const Drive& drive = GetParam();
  const BusyMachine machine{1e-3 * kBudget};
  const double before = time_of_children();
  ASSERT_EQ(run(drive.scenario, {"--dds", "--method", drive.method, "--speed", drive.speed}), 0);
  const auto result = json().at(0);
  EXPECT_EQ(result.at("collisions"), 0);
  if (result.at("plans") == 0) return;
  const double plans = result.at("plans").get<double>();
  EXPECT_LE(time_of_children() - before, 1e-3 * kBudget * plans) << "of all nodes";
  // Deadlines are wall-clock time: a busy machine takes the processor away from the planner as
  // often as from another thread that computes.
  const double late = machine.late_share();
  EXPECT_LE(result.at("plan_fallbacks").get<double>(), (0.01 + late) * plans);
  EXPECT_LE(result.at("plan_overruns").get<double>(), (0.002 + 2.0 * late) * plans);
  if (late == 0.0) {
    EXPECT_LE(result.at("plan_ms").at("p99").get<double>(), kBudget);
  }
}

#if defined(__SANITIZE_ADDRESS__)  // slow code misses its deadlines: only that it drives
INSTANTIATE_TEST_SUITE_P(Sanitized, OverDds,
                         ::testing::Values(Drive{"corridor", "safety_filter", "1"}),
                         [](const auto&) { return "corridor"; });
#else
INSTANTIATE_TEST_SUITE_P(
    Scenarios, OverDds,
    ::testing::Values(Drive{"forest_task2", "intention", "2"}, Drive{"forest_task2", "blend", "4"},
                      Drive{"forest_task1", "leader", "4"}, Drive{"corridor", "leader", "1"},
                      Drive{"corridor", "safety_filter", "4"}, Drive{"slalom", "leader", "4"},
                      Drive{"table_3_1", "goal", "4"}, Drive{"table_3_2", "goal", "4"}),
    [](const auto& test) { return std::string(test.param.scenario) + "_" + test.param.method; });
#endif

TEST_F(ScenarioProgram, OtherMethodsAndDriversDriveOverDds) {
  const std::pair<const char*, const char*> drives[] = {{"dwa", "navigator+tremor"},
                                                        {"adaptive", "pointer+dropouts"}};
  for (const auto& [method, driver] : drives) {
    EXPECT_EQ(
        run("forest_task2", {"--dds", "--method", method, "--driver", driver, "--speed", "4"}), 0)
        << method;
    const auto drive = json().at(0);
    EXPECT_EQ(drive.at("collisions"), 0) << method;
    EXPECT_EQ(drive.at("driver"), driver);
    EXPECT_GT(drive.at("plans"), 50) << method;
  }
}

TEST_F(ScenarioProgram, HindsightDrivesOverDdsThroughANodeOfItsOwn) {
  ASSERT_EQ(run("ward_goals", {"--dds", "--seed", "6", "--speed", "4"}), 0);
  const auto drive = json().at(0);
  EXPECT_EQ(drive.at("collisions"), 0);
  EXPECT_GT(drive.at("plans"), 50);
}

}  // namespace
}  // namespace tandem::test
