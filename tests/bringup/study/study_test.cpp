// SPDX-License-Identifier: Apache-2.0
// Tests study files.
#include "bringup/study/study.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include "bringup/scenario/seeded_world.hpp"
#include "support/instrumented.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

const std::string kScenarios = test::source_path("bringup/scenarios/");

class StudyTest : public ::testing::Test {
 protected:
  StudyTest() { fs::create_directories(folder_); }
  ~StudyTest() override { fs::remove_all(folder_); }

  [[nodiscard]] Study load(const std::string& text) const {
    std::ofstream{file_} << text;
    return load_study(file_.string());
  }
  // The error message of loading and checking; empty if there is none.
  [[nodiscard]] std::string complaint(const std::string& text) const {
    try {
      check_study(load(text));
      return {};
    } catch (const std::exception& error) {
      return error.what();
    }
  }

  const std::string text_ = "study: t\nscenarios: [" + kScenarios +
                            "forest_task2.yaml]\nmethods: [manual, leader]\nseeds: 1-3\n";
  fs::path folder_ = fs::temp_directory_path() / ("tandem_study_test_" + std::to_string(getpid()));
  fs::path file_ = folder_ / "s.yaml";
};

using StudyFile = StudyTest;

TEST_F(StudyFile, ListsEachScenarioMethodDriverAndSeed) {
  const Study study = load(text_);
  ASSERT_EQ(study.drives.size(), 6u);
  EXPECT_EQ(name_of(study, study.drives.front()), "forest_task2/manual/navigator/1");
  EXPECT_EQ(name_of(study, study.drives.back()), "forest_task2/leader/navigator/3");
}

TEST_F(StudyFile, DrivesItsScenariosWithOtherRobots) {
  const std::string robots = test::source_path("bringup/robots/");
  const Study study =
      load(text_ + "robots: [" + robots + "mir100.yaml, " + robots + "jackal.yaml]\n");
  ASSERT_EQ(study.cells.size(), 4U);
  EXPECT_EQ(study.cells[0].scenario.name, "forest_task2");  // its own robot
  EXPECT_EQ(study.cells[2].scenario.name, "forest_task2_jackal");
  EXPECT_EQ(study.cells[2].scenario.robot, robots + "jackal.yaml");
  EXPECT_NE(study.description, load(text_).description);
  EXPECT_NE(complaint(text_ + "robots: [nowhere.yaml]\n")
                .find("nowhere.yaml: no such file; Tandem's own robots are"),
            std::string::npos);
  EXPECT_NE(complaint(text_ + "robots: 3\n").find("`robots` must be a list"), std::string::npos);
}

TEST_F(StudyFile, PartsInheritFromTheTopLevel) {
  const Study study = load(text_ +
                           "parts:\n"
                           "  - {seeds: 1}\n"
                           "  - {methods: [path], seeds: [7, 9]}\n"
                           "  - {methods: all, scenarios: [{file: " +
                           kScenarios + "corridor.yaml, name: again, duration: 12}]}\n");
  std::vector<std::string> names;
  for (const auto& drive : study.drives) names.push_back(name_of(study, drive));
  EXPECT_EQ(names.size(), 2u + 2u + 3 * load_scenario(kScenarios + "corridor.yaml").methods.size());
  EXPECT_EQ(names[3], "forest_task2/path/navigator/9");
  EXPECT_EQ(study.cells.back().scenario.name, "again");
  EXPECT_EQ(study.cells.back().scenario.duration, 12.0);
}

TEST_F(StudyFile, OverridesReachTheComponentsAndTheNearestWins) {
  const Study study =
      load("study: t\nscenarios: [" + kScenarios +
           "forest_task2.yaml]\nseeds: 1\n"
           "overrides: {driver: {aim_noise: 0.5, preview: 0.7}, local_planner: {margin: 0.2}}\n"
           "methods: [{name: bare, method: leader, enforce: false,"
           " parameters: {local_planner: {margin: 0.1}}}]\n"
           "drivers: [{name: steady, aim_noise: 0.0}]\n");
  const StudyCell& cell = study.cells.front();
  EXPECT_EQ(cell.method, "bare");
  EXPECT_EQ(cell.driver, "steady");
  EXPECT_FALSE(cell.options.enforce);
  EXPECT_EQ(cell.scenario.parameters.at("driver").at("aim_noise").yaml, "0.0");
  EXPECT_EQ(cell.scenario.parameters.at("driver").at("preview").yaml, "0.7");
  EXPECT_EQ(cell.scenario.parameters.at("local_planner").at("margin").yaml, "0.1");
}

TEST_F(StudyFile, ThoseShippedAreSoundAndNeedOnlyTheMaps) {
  for (const std::string name : {"quick", "full"}) {
    if (test::kInstrumented && name == "full") continue;  // takes two minutes, for the same code
    const Study study = load_study(test::source_path("bringup/studies/" + name + ".yaml"));
    EXPECT_EQ(study.name, name);
    check_study(study);
  }
}

// A copy of a shipped scenario that plays a recording on a robot, each in a folder of its own.
void write_replayed(const fs::path& folder, const std::string& robot, const std::string& played) {
  fs::create_directories(folder / "drive");
  std::ofstream{folder / "robot.yaml"} << robot;
  std::ofstream{folder / "drive/drive_0.db3"} << played;
  std::ofstream{folder / "s.yaml"} << "scenario: " << folder.filename().string()
                                   << "\nmap: " << test::source_path("maps/forest.bt")
                                   << "\nrobot: robot.yaml\n"
                                      "start: [-4, -4, 0]\ngoal: {roam_time: 5}\nmethod: manual\n"
                                      "driver: replay\nrecording: drive\n";
}

TEST_F(StudyFile, IsAnotherOnceAnyFileOfItIsAnother) {
  const std::string text = "study: t\nscenarios: [a/s.yaml, b/s.yaml]\nseeds: 1\n";
  const auto with = [&](const char* robot_a, const char* robot_b, const char* played) {
    write_replayed(folder_ / "a", robot_a, played);
    write_replayed(folder_ / "b", robot_b, "same");
    return load(text).description;
  };
  const auto first = with("{}", "# b\n{}", "one");
  EXPECT_EQ(first, with("{}", "# b\n{}", "one"));
  EXPECT_NE(first, with("# b\n{}", "{}", "one"));  // robots of one name changed places
  EXPECT_NE(first, with("# a\n{}", "# b\n{}", "one"));
  EXPECT_NE(first, with("{}", "# b\n{}", "two"));
  for (const char* file : {"a/robot.yaml", "b/robot.yaml", "a/s.yaml", "a/drive/drive_0.db3"})
    EXPECT_TRUE(first.contains(file)) << file << " not in " << first.dump();
}

TEST_F(StudyFile, OfManyWorldsHasAWorldForEachSeed) {
  std::ofstream{folder_ / "w.json"} << R"({"meta": {"cylinder_radius_m": 0.1, "start": {"x": -4,
      "y": -4}, "goal": {"x": 4, "y": 2.5}}, "worlds": {"7": {"cylinders": [[1, 3]]}}})";
  const std::string text = "study: t\nscenarios: [{file: " + kScenarios +
                           "forest_task2.yaml, map: w.json}]\nmethods: [manual]\nseeds: ";
  EXPECT_EQ(complaint(text + "1"), "");
  EXPECT_NE(complaint(text + "1-2").find("seed 2 is not one of its worlds; name seeds from 1 to 1"),
            std::string::npos);
}

TEST_F(StudyFile, PlaysTheRecordingOfADriver) {
  const auto with = [&](const char* played) {
    std::ofstream{folder_ / "me.db3"} << played;
    return load(
        text_ +
        "drivers: [{name: me, driver: replay, recording: me.db3, recording_topic: /a/joy}]\n");
  };
  Study study = with("one");
  EXPECT_EQ(study.cells.front().driver, "me");
  EXPECT_EQ(study.cells.front().options.recording, (folder_ / "me.db3").string());
  EXPECT_EQ(study.cells.front().options.recording_topic, "/a/joy");
  EXPECT_FALSE(study.cells.front().scenario.parameters["driver"].contains("recording"));
  EXPECT_NE(study.description, with("two").description);
}

struct Mistake {
  const char *name, *from, *to, *complaint;
};

class Mistaken : public StudyTest, public ::testing::WithParamInterface<Mistake> {};

TEST_P(Mistaken, IsRefusedInOneLineThatNamesTheFile) {
  std::string text = text_;
  const std::string from = GetParam().from;
  ASSERT_NE(text.find(from), std::string::npos);
  const std::string line = complaint(text.replace(text.find(from), from.size(), GetParam().to));
  EXPECT_NE(line.find("s.yaml:"), std::string::npos) << line;
  EXPECT_NE(line.find(GetParam().complaint), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos) << line;
}

INSTANTIATE_TEST_SUITE_P(
    Files, Mistaken,
    ::testing::Values(
        Mistake{"key", "seeds", "sedes", ":4: unknown key `sedes`; valid keys: "},
        Mistake{"key_twice", "seeds: 1-3", "seeds: 1\nmethods: [path]",
                ":5: `methods` is given twice, first in line 3"},
        Mistake{"driver_key_twice", "seeds: 1-3",
                "seeds: 1\ndrivers: [{name: x, preview: 0.7, preview: 0.8}]", "given twice"},
        Mistake{"yaml", "seeds: 1-3", "seeds: [1", "s.yaml:"},
        Mistake{"no_name", "study: t\n", "", ":1: `study` is missing"},
        Mistake{"name_of_a_path", "study: t", "study: a/t", ":1: `study` = a/t: a name may not"},
        Mistake{"method_name", "leader", "{name: a/b, method: leader}",
                ":3: `methods[1].name` = a/b: a name may not hold a `/`"},
        Mistake{"no_methods", "[manual, leader]", "[]", ":3: `methods` must be a list of methods"},
        Mistake{"no_seeds", "seeds: 1-3\n", "", "`seeds` is missing"},
        Mistake{"seeds_0", "1-3", "0", "`seeds` = 0: expected 20, 1-20 or [3, 5, 8]"},
        Mistake{"seeds_word", "1-3", "many", "`seeds` = many: expected"},
        Mistake{"seeds_minus", "1-3", "[-3]", "`seeds` = [-3]: expected"},
        Mistake{"seeds_back", "1-3", "3-1", "seeds 3-1: expected N or A-B with 1 <= A <= B"},
        Mistake{"no_seed", "1-3", "[]", "`seeds` = []: expected"},
        Mistake{"method", "leader", "magic", ":3: method `magic` is not one of manual, "},
        Mistake{"methods", "[manual, leader]", "some",
                "`methods` must be a list of methods, or `all`"},
        Mistake{"no_scenarios", "scenarios: ", "about: ", "`scenarios` must be a list"},
        Mistake{"twice", "[manual, leader]", "[manual, manual]", "is listed twice"},
        Mistake{"component", "seeds: 1-3", "seeds: 1\noverrides: {planer: {margin: 0.1}}",
                "parameters for `planer`, which is not one of"},
        Mistake{"parameter", "seeds: 1-3", "seeds: 1\noverrides: {local_planner: {magrin: 0.1}}",
                "magrin"},
        Mistake{"driver", "seeds: 1-3", "seeds: 1\ndrivers: [{nmae: x}]",
                ":5: `drivers[0].name` is missing; is `nmae` a misspelling of it?"},
        Mistake{"replay_of_nothing", "seeds: 1-3", "seeds: 1\ndrivers: [replay]",
                "driver `replay` also needs a `recording`"},
        Mistake{"recording_of_another", "seeds: 1-3",
                "seeds: 1\ndrivers: [{name: x, driver: pointer, recording: y}]",
                ":5: a `recording` needs `driver: replay`"},
        Mistake{"part", "seeds: 1-3", "seeds: 1\nparts: []", "`parts` must be a list"},
        Mistake{"part_key", "seeds: 1-3", "seeds: 1\nparts: [{sede: 1}]",
                "unknown key `parts[0].sede`"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST_F(StudyFile, RefusesAScenarioNameThatIsNotAFileName) {
  EXPECT_NE(complaint("study: t\nscenarios: [{file: " + kScenarios +
                      "forest_task2.yaml, name: a/b}]\nseeds: 1\n")
                .find("s.yaml:2: `scenarios[0].name` = a/b: a name may not hold a `/`"),
            std::string::npos);
}

TEST_F(StudyFile, NamesAMissingScenario) {
  EXPECT_NE(complaint("study: t\nscenarios: [nowhere.yaml]\nseeds: 1\n")
                .find("s.yaml:2: `scenarios[0]`: " + (folder_ / "nowhere.yaml").string()),
            std::string::npos);
}

TEST(Seeds, AreRangesAndBack) {
  const std::vector<unsigned> seeds{1, 2, 3, 7, 9, 10};
  EXPECT_EQ(seed_ranges(seeds), "1-3,7,9-10");
  EXPECT_EQ(seeds_in("1-3,7,9-10"), seeds);
  EXPECT_EQ(seeds_in(""), std::vector<unsigned>{});
  for (const char* text : {"0", "a", "1-", "-2", "1;2", "3-1", "1-4294967295"})
    EXPECT_THROW((void)seeds_in(text), std::invalid_argument) << text;
}

}  // namespace
}  // namespace tandem
