// SPDX-License-Identifier: Apache-2.0
// Tests drives in lockstep one after the other.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "bringup/drive/lockstep.hpp"
#include "bringup/scenario/seeded_world.hpp"
#include "support/instrumented.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

// The results of a drive that do not depend on a clock.
nlohmann::json measures(DriveResult result) {
  result.wall_s = result.cpu_s = 0.0;
  result.part_s = {};
  result.plan_ms = {};
  result.missed_deadlines = 0;
  return result;
}

TEST(Lockstep, KeepsWorldsWithoutChangingADrive) {
  std::vector<Scenario> scenarios;
  for (const char* name : {"forest_task2.yaml", "corridor.yaml"}) {
    scenarios.push_back(load_scenario(test::source_path("bringup/scenarios/") + name));
    scenarios.back().duration = test::kInstrumented ? 2.0 : 6.0;  // [s]
  }
  Lockstep kept;
  for (const unsigned seed : {1U, 2U})
    for (const Scenario& scenario : scenarios)
      for (const bool obstacles : {false, true}) {
        const DriveOptions options{.seed = seed, .lockstep = true};
        const Scenario drive = obstacles ? scenario : without_obstacles(scenario);
        EXPECT_EQ(measures(kept.drive(drive, options).result),
                  measures(drive_in_lockstep(drive, options).result))
            << scenario.name << seed << obstacles;
      }
}
}  // namespace
}  // namespace tandem
