// SPDX-License-Identifier: Apache-2.0
// Tests what a scenario file may contain, and the error messages for invalid files.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <stdexcept>

#include "bringup/drive/lockstep.hpp"
#include "support/paths.hpp"
#include "tandem/diff_drive_sim/diff_drive_sim_node.hpp"
#include "tandem/hindsight/hindsight_node.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/obstacle_extractor/obstacle_extractor_node.hpp"
#include "tandem/safety_filter/safety_filter_node.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

class ScenarioFile : public ::testing::Test {
 protected:
  ScenarioFile() { fs::create_directories(folder_); }
  ~ScenarioFile() override { fs::remove_all(folder_); }

  void write(std::string text, const std::string& from = "", const std::string& to = "") const {
    if (!from.empty()) {
      ASSERT_NE(text.find(from), std::string::npos) << from;
      text.replace(text.find(from), from.size(), to);
    }
    std::ofstream{file_} << text;
  }
  // The error message of loading and checking; empty if there is none.
  [[nodiscard]] std::string complaint() const {
    try {
      check_drive(load_scenario(file_.string()), DriveOptions{});
      return {};
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  }

  const std::string text_ =
      "scenario: t\n"
      "map: " +
      test::source_path("maps/forest.bt") +
      "\nrobot: " + test::source_path("bringup/robots/mir100.yaml") +
      "\nstart: [-4.0, -4.0, 0.0]\n"
      "goal: {region: [3.0, 1.5, 5.0, 3.5]}\n"
      "method: leader\n"
      "duration: 60\n"
      "parameters: {driver: {route: [4.0, 2.5]}}\n"
      "expect: {reached: true}\n";
  fs::path folder_ =
      fs::temp_directory_path() / ("tandem_scenario_file_" + std::to_string(getpid()));
  fs::path file_ = folder_ / "s.yaml";
};

TEST_F(ScenarioFile, AValidFileIsAccepted) {
  write(text_);
  EXPECT_EQ(complaint(), "");
}

TEST_F(ScenarioFile, MayHavePeopleThatFilterAndPlannerThenWatch) {
  write(text_, "duration: 60",
        "duration: 60\npeople: [{way: [0, -2, 2, -2], speed: 1.2}, {crossings: 3, area: [-1, -1, "
        "1, 1]}]");
  EXPECT_EQ(complaint(), "");
  const Scenario scenario = load_scenario(file_.string());
  ASSERT_EQ(people_in(scenario).size(), 4U);
  EXPECT_EQ(people_in(scenario)[0].speed, 1.2);
  const System system = system_of(scenario, {});
  EXPECT_EQ(parameters_of<DiffDriveSimNodeParams>(system, "diff_drive_sim").people,
            to_numbers(people_in(scenario)));
  EXPECT_TRUE(parameters_of<SafetyFilterNodeParams>(system, "safety_filter").filter.people.watched);
  EXPECT_TRUE(parameters_of<ObstacleExtractorNodeParams>(system, "obstacle_extractor").people);
}

TEST_F(ScenarioFile, WithSeveralGoalsGivesEachSeedOne) {
  std::string by_hindsight = text_;
  by_hindsight.replace(by_hindsight.find("leader"), 6, "hindsight");
  write(by_hindsight, "region: [3.0, 1.5, 5.0, 3.5]", "poses: [4, 2.5, 0, -4, 0, 1.5]");
  EXPECT_EQ(complaint(), "");
  const Scenario scenario = load_scenario(file_.string());
  const double x[] = {4.0, -4.0, 4.0};
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Scenario drive = with_options(scenario, {.seed = seed});
    EXPECT_EQ(std::get<PoseGoal>(drive.goal).X_MG.x, x[seed - 1]);
    const System system = system_of(drive, {});
    EXPECT_EQ(parameters_of<HindsightNodeParams>(system, "hindsight").hindsight.goals,
              (std::vector<double>{4.0, 2.5, 0.0, -4.0, 0.0, 1.5}));
  }
}

TEST_F(ScenarioFile, MayWantAnEdgeOfTheRobotAtItsGoal) {
  write(text_, "region: [3.0, 1.5, 5.0, 3.5]",
        "pose: [4, 2, 1.5708], of: front, tolerance: 0.05, heading_tolerance: 0.1, stand: 2, "
        "after: [1, 1, 2, 2]");
  EXPECT_EQ(complaint(), "");
  const Scenario scenario = load_scenario(file_.string());
  const Scenario drive = with_options(with_options(scenario, {}), {});  // once is enough
  const auto& goal = std::get<PoseGoal>(drive.goal);
  const double front =
      extent(
          footprint_of(
              parameters_of<DiffDriveSimNodeParams>(system_of(drive, {}), "diff_drive_sim").robot))
          .front;
  EXPECT_NEAR(goal.X_MG.x, 4.0, 1e-4);
  EXPECT_NEAR(goal.X_MG.y, 2.0 - front, 1e-4);
  EXPECT_EQ(goal.stand, 2.0);
  EXPECT_EQ(drive.after->high.x(), 2.0);
  EXPECT_EQ(drive.p_BA.x(), front);
  write(text_, "region: [3.0, 1.5, 5.0, 3.5]", "pose: [4, 2, 0], of: nose");
  EXPECT_NE(complaint().find("`goal.of` = nose is not one of front, rear, left, right"),
            std::string::npos);
  write(text_, "region: [3.0, 1.5, 5.0, 3.5]", "region: [3.0, 1.5, 5.0, 3.5], of: left");
  EXPECT_NE(complaint().find("`goal.of` is about a pose or `after`"), std::string::npos);
  write(text_, "region: [3.0, 1.5, 5.0, 3.5]", "pose: [4, 2, 0], stand: -1");
  EXPECT_NE(complaint().find("`goal.stand` must be 0 or more"), std::string::npos);
}

// A file of BARN worlds, 1 to `count`, each with one cylinder at (x, 3).
void write_barn(const fs::path& file, double x, int count) {
  fs::create_directories(file.parent_path());
  std::ofstream out{file};
  out << R"({"meta": {"cylinder_radius_m": 0.1, "start": {"x": -4, "y": -4},
             "goal": {"x": 4, "y": 2.5}}, "worlds": {)";
  for (int n = 1; n <= count; ++n)
    out << (n > 1 ? ", " : "") << '"' << n << R"(": {"cylinders": [[)" << x << ", 3]]}";
  out << "}}";
}

TEST_F(ScenarioFile, OfManyWorldsKeepsApartThoseOfTwoFilesOfOneName) {
  write_barn(folder_ / "a/worlds.json", 1.0, 1);
  write_barn(folder_ / "b/worlds.json", -1.0, 1);
  write(text_);
  const Scenario scenario = load_scenario(file_.string());
  const auto of = [&](const char* file) {
    return with_options(scenario, {.map = (folder_ / file).string()});
  };
  const Scenario a = of("a/worlds.json"), b = of("b/worlds.json"), again = of("a/worlds.json");
  EXPECT_NE(a.map, b.map);
  EXPECT_EQ(a.map, again.map);  // so that resumed and merged studies agree
  const auto solid = [](const Scenario& in, double x) {
    const auto tree = load_octomap(in.map);
    const auto* node = tree->search(x, 3.0, 0.5);
    return node != nullptr && tree->isNodeOccupied(node);
  };
  EXPECT_TRUE(solid(a, 1.0) && !solid(a, -1.0));
  EXPECT_TRUE(solid(b, -1.0) && !solid(b, 1.0));
}

TEST_F(ScenarioFile, OfManyWorldsHasAWorldForEachSeedOrRefusesIt) {
  write_barn(folder_ / "c.json", 1.0, 2);
  write(text_, test::source_path("maps/forest.bt"), "c.json");
  const Scenario scenario = load_scenario(file_.string());
  EXPECT_NO_THROW((void)with_options(scenario, {.seed = 2}));
  try {
    check_drive(scenario, {.seed = 3});
    FAIL() << "went round";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string{error.what()}.find(
                  "c.json: seed 3 is not one of its worlds; name seeds from 1 to 2"),
              std::string::npos)
        << error.what();
  }
}

struct Mistake {
  const char *name, *from, *to, *complaint;
};

class Mistaken : public ScenarioFile, public ::testing::WithParamInterface<Mistake> {};

TEST_P(Mistaken, IsRefusedInOneLineThatNamesFileAndValue) {
  write(text_, GetParam().from, GetParam().to);
  const std::string line = complaint();
  EXPECT_TRUE(line.starts_with(file_.string())) << line;
  EXPECT_NE(line.find(GetParam().complaint), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos) << line;
}

INSTANTIATE_TEST_SUITE_P(
    Files, Mistaken,
    ::testing::Values(
        Mistake{"unknown_key", "duration", "durtion", ":7: unknown key `durtion`; valid keys: "},
        Mistake{"missing_key", "method: leader\n", "", "`method` is missing"},
        Mistake{"key_twice", "duration: 60", "duration: 60\nduration: 70", "is given twice"},
        Mistake{"key_no_word", "duration: 60", "? [a]\n: 1", "a key must be a word"},
        Mistake{"empty", "scenario: t", "#", "`scenario` is missing"},
        Mistake{"name_of_a_path", "scenario: t", "scenario: a/t", ":1: `scenario` = a/t: a name"},
        Mistake{"name_empty", "scenario: t", "scenario: ''", ":1: `scenario` = : a name needs"},
        Mistake{"no_methods", "duration: 60", "methods: []", ":7: `methods` is empty; list one"},
        Mistake{"wrong_type", "60", "long", ":7: `duration` = long is not a finite number"},
        Mistake{"duration_nan", "60", ".nan", "`duration` = .nan is not a finite number"},
        Mistake{"duration_inf", "60", ".inf", "`duration` = .inf is not a finite number"},
        Mistake{"duration_negative", "60", "-5", "`duration` = -5 outside (0, 1000000]"},
        Mistake{"start_nan", "[-4.0, ", "[.nan, ", "is not a list of finite numbers"},
        Mistake{"start_short", "-4.0, 0.0]", "-4.0]", ":4: `start` needs three numbers"},
        Mistake{"start_in_a_pole", "[-4.0, -4.0, ", "[-2.0, -2.0, ",
                "start: at [-2, -2, 0] the robot's outline overlaps an obstacle"},
        Mistake{"start_off_the_map", "[-4.0, -4.0, 0.0]", "[-40, 0, 0]",
                "start: [-40, 0] is outside "},
        Mistake{"goal_off_the_map", "[3.0, 1.5, 5.0, 3.5]", "[30, 1, 31, 2]",
                "goal: [30.5, 1.5] is outside "},
        Mistake{"region_nan", "[3.0, ", "[.nan, ", ":5: `goal.region` = [.nan, 1.5, 5.0, 3.5]"},
        Mistake{"region_inverted", "[3.0, ", "[6.0, ",
                ":5: `goal.region` needs [x1, y1, x2, y2] with x1 < x2"},
        Mistake{"region_short", ", 3.5]", "]", ":5: `goal.region` needs [x1, y1, x2, y2]"},
        Mistake{"two_goals", "{region", "{pose: [1, 1, 0], region", "goal needs one of"},
        Mistake{"no_tolerance", "region: [3.0, 1.5, 5.0, 3.5]", "pose: [1, 1, 0], tolerance: 0",
                ":5: `goal.tolerance` must be above 0"},
        Mistake{"poses_short", "region: [3.0, 1.5, 5.0, 3.5]", "poses: [1, 1, 0, 2]",
                "`goal.poses` needs x1, y1, heading1, x2"},
        Mistake{"hindsight_without_poses", "leader", "hindsight",
                "`hindsight` needs goal: {poses:"},
        Mistake{"goal_without_pose", "leader", "goal", "method `goal` needs goal: {pose:"},
        Mistake{"method", "leader", "magic", "method `magic` is not one of manual, safety_filter"},
        Mistake{"except", "true}", "true, except: [magic]}", "method `magic` is not one of"},
        Mistake{"expect_nan", "true}", "true, max_final_position_error: .nan}", "= .nan is not"},
        Mistake{"route_odd", "[4.0, 2.5]", "[4.0]", "route: expected points x1, y1, x2, y2"},
        Mistake{"route_nan", "[4.0, 2.5]", "[4.0, .nan]", ":8: node /driver: route = nan outside"},
        Mistake{"unknown_parameter", "{route", "{rout",
                ":8: node /driver: rout = [4.0, 2.5] is not a parameter of this node; did you mean "
                "`route`?"},
        Mistake{"unknown_parameter_of_another_method", "{driver: {route", "{hindsight: {goal",
                ":8: node /hindsight: goal = [4.0, 2.5] is not a parameter of this node; did you "
                "mean `goals`?"},
        Mistake{"unknown_component", "{driver", "{diver", ":8: parameters for `diver`, which is"},
        Mistake{"parameters_scalar", "{driver: {route: [4.0, 2.5]}}", "5",
                ":8: `parameters`: expected `key"},
        Mistake{"parameters_list", "{route: [4.0, 2.5]}", "[1, 2]",
                ":8: `parameters.driver`: expected `key: value`"},
        Mistake{"slice_over_everything", "duration: 60", "slice: {z_min: 5, z_max: 6}",
                "contains nothing between 5 m and 6 m"},
        Mistake{"people_no_list", "duration: 60", "people: 3", ":7: `people`: expected a list"},
        Mistake{"people_without_way", "duration: 60", "people: [{speed: 1}]",
                ":7: `people[0].way` is missing"},
        Mistake{"people_odd_way", "duration: 60", "people: [{way: [1, 2, 3]}]",
                "`people[0].way` needs x1"},
        Mistake{"people_backward", "duration: 60", "people: [{way: [1, 2], speed: -1}]",
                "`speed` outside [0, 5]"},
        Mistake{"people_thin", "duration: 60", "people: [{way: [1, 2], radius: 0}]",
                "`radius` outside [0.05, 5]"},
        Mistake{"people_unknown_key", "duration: 60", "people: [{way: [1, 2], spede: 1}]",
                "unknown key `people[0].spede`; valid keys: "},
        Mistake{"crossings_area", "duration: 60", "people: [{crossings: 3, area: [1, 1, 0, 2]}]",
                "`people[0].area` needs [x1, y1, x2, y2]"},
        Mistake{"crossings_too_many", "duration: 60",
                "people: [{crossings: 999, area: [0, 0, 1, 1]}]",
                "`people[0].crossings` outside [0, 100]"},
        Mistake{"seed_too_large", "duration: 60", "seed: 4294967295", "above the largest"},
        Mistake{"map_missing", "forest.bt", "nowhere.bt", "nowhere.bt: no such file"},
        Mistake{"robot_folder", "/mir100.yaml", "", "/robots is a folder; name a file in it"},
        Mistake{"robot_missing", "mir100", "nobot",
                "nobot.yaml: no such file; Tandem's own robots are: fork_truck, jackal"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST_F(ScenarioFile, MapAndRobotMayBeNamesOfTandemsOwn) {
  write(std::regex_replace(text_, std::regex{"map: .*\nrobot: .*\n"},
                           "map: forest\nrobot: wheelchair\n"));
  const Scenario scenario = load_scenario(file_.string());
  EXPECT_TRUE(fs::equivalent(scenario.map, test::source_path("maps/forest.bt"))) << scenario.map;
  EXPECT_TRUE(fs::equivalent(scenario.robot, test::source_path("bringup/robots/wheelchair.yaml")));
  EXPECT_EQ(complaint(), "");
}

TEST_F(ScenarioFile, RobotOfNegativeSizeIsRefused) {
  std::ofstream{folder_ / "robot.yaml"} << "/**:\n  ros__parameters:\n    width: -0.5\n";
  write(text_, test::source_path("bringup/robots/mir100.yaml"), "robot.yaml");
  EXPECT_NE(complaint().find("robot.yaml:3: node /"), std::string::npos) << complaint();
  EXPECT_NE(complaint().find("width = -0.5 outside [0.05, 5]"), std::string::npos);
}

TEST_F(ScenarioFile, RobotMayHaveAnOutlineOfSeveralParts) {
  write(text_, "mir100.yaml", "fork_truck.yaml");
  EXPECT_EQ(complaint(), "");
  const Scenario scenario = load_scenario(file_.string());
  EXPECT_NO_THROW(check_robot(scenario));
  const auto sim = parameters_of<DiffDriveSimNodeParams>(system_of(scenario, {}), "diff_drive_sim");
  EXPECT_EQ(footprint_of(sim.robot).parts.size(), 3U);
}

TEST_F(ScenarioFile, RobotWithADentedOutlineIsRefusedWithPartAndVertex) {
  std::ofstream{folder_ / "robot.yaml"} << "/**:\n  ros__parameters:\n    footprint: [-1, -1, 1, "
                                           "-1, 1, 1, -1, 1, 0, 0, 2, 0, 1, 0.2, 1, "
                                           "1]\n    footprint_parts: [4, 4]\n";
  write(text_, test::source_path("bringup/robots/mir100.yaml"), "robot.yaml");
  EXPECT_NE(complaint().find("footprint: part 2, vertex 3 at (1, 0.2): the outline turns right"),
            std::string::npos)
      << complaint();
}

TEST_F(ScenarioFile, RobotWithADifferentNumberOfVerticesThanItsPartsIsRefused) {
  std::ofstream{folder_ / "robot.yaml"} << "/**:\n  ros__parameters:\n    footprint: [-1, -1, 1, "
                                           "-1, 0, 1]\n    footprint_parts: [3, 3]\n";
  write(text_, test::source_path("bringup/robots/mir100.yaml"), "robot.yaml");
  EXPECT_NE(complaint().find("the parts have 6 vertices in all, but footprint gives 3"),
            std::string::npos)
      << complaint();
}

TEST_F(ScenarioFile, RobotWithAMisspeltKeyIsRefusedWithASuggestion) {
  std::ofstream{folder_ / "misspelt.yaml"} << "/**:\n  ros__parameters:\n    widht: 0.5\n";
  write(text_, test::source_path("bringup/robots/mir100.yaml"), "misspelt.yaml");
  try {
    check_robot(load_scenario(file_.string()));
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    const std::string line = error.what();
    EXPECT_TRUE(
        line.starts_with((folder_ / "misspelt.yaml").string() + ":3: widht: unknown parameter"))
        << line;
    EXPECT_NE(line.find("did you mean `width`?"), std::string::npos) << line;
  }
}

TEST_F(ScenarioFile, RobotMayNameWhatOnlyAnotherMethodOrNodeUses) {
  std::ofstream{folder_ / "more.yaml"}
      << "/**:\n  ros__parameters:\n    change_of_mind: 1.0\n    width: 0.5\n"
         "    use_sim_time: true\n    qos_overrides: {/odom: {publisher: {depth: 2}}}\n"
         "camera:\n  ros__parameters: {widht: 640}\n";
  write(text_, test::source_path("bringup/robots/mir100.yaml"), "more.yaml");
  EXPECT_EQ(complaint(), "");
  EXPECT_NO_THROW(check_robot(load_scenario(file_.string())));
}

TEST(ShippedScenarios, HaveRobotsWithoutAMisspeltKey) {
  for (const auto& file : test::yaml_files("bringup/scenarios"))
    EXPECT_NO_THROW(check_robot(load_scenario(file))) << file;
}

// Beside tests/bringup/system/system_test.cpp, which is of how systems run.
TEST_F(ScenarioFile, OfASystemHasEachKeyOnce) {
  const std::string whole = "components:\n  - component: c\n    parameters: {a: 1}\n";
  for (const std::string more :
       {"    component: d\n", "    remappings: {p: q, p: r}\n", "    parameters: {b: 1}\n",
        "    namespace: /n\n    namespace: /m\n", "components: []\n"}) {
    write(whole + more);
    try {
      (void)load_system(file_.string());
      ADD_FAILURE() << "accepted: " << more;
    } catch (const std::invalid_argument& error) {
      const std::string line = error.what();
      EXPECT_TRUE(line.starts_with(file_.string() + ":")) << line;
      EXPECT_NE(line.find("is given twice"), std::string::npos) << line;
    }
  }
}

}  // namespace
}  // namespace tandem
