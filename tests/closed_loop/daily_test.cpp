// SPDX-License-Identifier: Apache-2.0
// Tests everyday tasks, each driven by hand: every shipped daily_*.yaml can be completed.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "bringup/drive/lockstep.hpp"
#include "bringup/study/study.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

class Daily : public ::testing::TestWithParam<std::string> {};

TEST_P(Daily, IsDoneByHand) {
  const Scenario scenario = load_scenario(GetParam());
  const DriveOptions options{.method = "manual", .seed = 1, .lockstep = true};
  const DriveResult result = drive_in_lockstep(scenario, options).result;
  EXPECT_TRUE(result.reached);
  EXPECT_TRUE(result.failures.empty());
}

// Covers the methods that plan, except those that the file excludes.
TEST_P(Daily, IsDoneWithThePlannerToo) {
  const Scenario scenario = load_scenario(GetParam());
  for (const char* method : {"leader", "intention"}) {
    const DriveResult result =
        drive_in_lockstep(scenario, {.method = method, .seed = 1, .lockstep = true}).result;
    EXPECT_TRUE(result.failures.empty()) << method << ": " << result.failures.front();
    EXPECT_EQ(result.collisions, 0) << method;
  }
}

INSTANTIATE_TEST_SUITE_P(Tasks, Daily,
                         ::testing::ValuesIn(test::yaml_files("bringup/scenarios", "daily_")),
                         [](const auto& test) {
                           return std::filesystem::path{test.param}.stem().string();
                         });

TEST(DailyTasks, AreAllInTheStudiesWithTheirDriver) {
  for (const char* file : {"daily", "full"}) {
    const Study study = load_study(test::source_path("bringup/studies/") + file + ".yaml");
    std::set<std::string> driven;
    for (const StudyCell& cell : study.cells)
      if (cell.scenario.driver == "script") driven.insert(cell.scenario.path);
    EXPECT_EQ(driven.size(), test::yaml_files("bringup/scenarios", "daily_").size()) << file;
  }
}

}  // namespace
}  // namespace tandem
