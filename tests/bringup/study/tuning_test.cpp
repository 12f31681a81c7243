// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/tuning.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bringup/scenario/scenario.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

System forest() {
  const Scenario scenario = load_scenario(test::source_path("bringup/scenarios/forest_task2.yaml"));
  return system_of(scenario, DriveOptions{});
}

std::string complaint(const std::string& text) {
  try {
    (void)read_knob(text, forest());
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(Knob, WithoutBoundsSpansAFifthToFiveTimesItsValue) {
  const Knob knob = read_knob("local_planner.weight_heading", forest());
  EXPECT_DOUBLE_EQ(knob.low, knob.start / 5.0);
  EXPECT_DOUBLE_EQ(knob.high, knob.start * 5.0);
  EXPECT_FALSE(knob.is_integer);
}

TEST(Knob, OfAnIntegerIsOne) {
  const Knob knob = read_knob("local_planner.horizon_steps:10:30", forest());
  EXPECT_TRUE(knob.is_integer);
  EXPECT_EQ(knob.low, 10.0);
  EXPECT_EQ(knob.high, 30.0);
}

TEST(Knob, ThatIsNoneIsRefusedWithTheReason) {
  EXPECT_NE(complaint("weight_x").find("component.parameter"), std::string::npos);
  EXPECT_NE(complaint("nobody.weight_x").find("not one of local_planner"), std::string::npos);
  EXPECT_NE(complaint("local_planner.solver").find("has no number"), std::string::npos);
  EXPECT_NE(complaint("local_planner.weight_x:5:1").find("increasing"), std::string::npos);
  EXPECT_NE(complaint("local_planner.weight_x:1:1e9").find("within"), std::string::npos);
  EXPECT_NE(complaint("local_planner.weight_x:1").find("expected"), std::string::npos);
  EXPECT_NE(complaint("local_planner.disc_radius").find("name its bounds"), std::string::npos);
}

TEST(Knob, WhoseValueNowIsOutsideItsBoundsIsRefused) {
  EXPECT_EQ(complaint("local_planner.horizon_steps:10:30"), "");
  EXPECT_NE(complaint("local_planner.horizon_steps:2:3").find("now: name bounds that hold it"),
            std::string::npos)
      << complaint("local_planner.horizon_steps:2:3");
}

TEST(Knobs, AreOfComponentsThatADrivenMethodUsesAndEachIsOne) {
  const auto complaint = [](const std::vector<std::string>& texts,
                            const std::vector<std::string>& methods) {
    const Scenario scenario =
        load_scenario(test::source_path("bringup/scenarios/forest_task2.yaml"));
    std::vector<System> systems;
    for (const auto& method : methods)
      systems.push_back(system_of(with_options(scenario, {.method = method}), {}));
    try {
      return read_knobs(texts, systems).size() == texts.size() ? std::string{} : "how many?";
    } catch (const std::invalid_argument& error) {
      return std::string{error.what()};
    }
  };
  EXPECT_EQ(complaint({"local_planner.weight_x", "teleop.scale_linear"}, {"manual", "leader"}), "");
  for (const std::string knob : {"local_planner.weight_x", "obstacle_extractor.range:1:20"})
    EXPECT_NE(complaint({knob}, {"manual", "dwa"}).find("no method that is driven uses"),
              std::string::npos)
        << complaint({knob}, {"manual", "dwa"});
  EXPECT_NE(complaint({"local_planner.weight_x", "local_planner.weight_x:0.1:20"}, {"leader"})
                .find("once"),
            std::string::npos);
}

double bowl(const std::vector<double>& v) {
  return std::pow(std::log(v[0] / 2.0), 2) + std::pow(v[1] + 0.3, 2);
}

TEST(Tune, FindsTheLeastCost) {
  const std::vector<Knob> knobs{{"c", "a", 0.1, 10.0, 8.0, false},
                                {"c", "b", -1.0, 1.0, 0.9, false}};
  const Tuned tuned = tune(knobs, 200, bowl, bowl);
  EXPECT_NEAR(tuned.values[0], 2.0, 0.05);
  EXPECT_NEAR(tuned.values[1], -0.3, 0.02);
}

TEST(Tune, NeverReturnsWorseThanItsStartNorCallsMoreOftenThanAllowed) {
  const std::vector<Knob> knobs{{"c", "a", 1.0, 10.0, 3.0, true}};
  int calls = 0;
  const Cost cost = [&](const std::vector<double>& v) {
    ++calls;
    EXPECT_EQ(v[0], std::round(v[0]));
    return v[0] == 3.0 ? 0.0 : 1.0;
  };
  const Cost prefers_others = [](const std::vector<double>& v) { return v[0] == 3.0 ? 1.0 : 0.0; };
  const Tuned tuned = tune(knobs, 7, cost, prefers_others);
  EXPECT_EQ(tuned.values[0], 3.0);
  EXPECT_LE(calls, 7);
}

// Values that are better only for the persons of the search are overfitted.
TEST(Tune, KeepsWhatIsBetterElsewhereToo) {
  const std::vector<Knob> knobs{{"c", "a", 0.1, 10.0, 8.0, false},
                                {"c", "b", -1.0, 1.0, 0.9, false}};
  const Cost optimum_at_4 = [](const std::vector<double>& v) {
    return std::pow(std::log(v[0] / 4.0), 2);
  };
  const Tuned tuned = tune(knobs, 200, bowl, optimum_at_4);
  EXPECT_LT(tuned.cost, bowl({8.0, 0.9}));
  EXPECT_LT(tuned.other_cost, 0.1 * optimum_at_4({8.0}));
  EXPECT_EQ(tuned.cost, bowl(tuned.values));
  EXPECT_EQ(tuned.other_cost, optimum_at_4(tuned.values));

  const Cost contrary = [](const std::vector<double>& v) { return -bowl(v); };
  EXPECT_DOUBLE_EQ(tune(knobs, 200, bowl, contrary).values[0], 8.0)
      << "its start is better elsewhere";
}

TEST(DriveCost, RisesWithWhateverIsWorse) {
  DriveResult drive;
  drive.reached = true;
  drive.time_to_goal_s = 10.0;
  drive.counts.filter_commands = 100;
  const double good = drive_cost(drive, 10.0);
  EXPECT_DOUBLE_EQ(good, 1.0);
  DriveResult slow = drive, disobedient = drive, filtered = drive, stuck = drive, hit = drive,
              lost = drive;
  slow.time_to_goal_s = 12.0;
  disobedient.obedience_rms = 0.1;
  filtered.counts.filter_interventions = 5;
  stuck.stuck_s = 1.0;
  hit.collisions = 1;
  lost.reached = false;
  for (const auto& worse : {slow, disobedient, filtered, stuck, hit, lost})
    EXPECT_GT(drive_cost(worse, 10.0), good);
  EXPECT_GT(drive_cost(hit, 10.0), drive_cost(slow, 10.0));
}

}  // namespace
}  // namespace tandem
