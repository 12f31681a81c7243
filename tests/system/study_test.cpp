// SPDX-License-Identifier: Apache-2.0
// Runs `tandem study` as a user does, on the example study that is shipped.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kDrives = 24, kGroups = 8;
constexpr double kLong = 300.0;  // [s] for a sanitizer on a busy machine

class StudyProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder() = fs::temp_directory_path() / ("tandem_study_" + std::to_string(getpid()));
    fs::create_directories(folder());
    ASSERT_EQ(run({study(), "--out", out("whole")}), 0);
  }
  static void TearDownTestSuite() { fs::remove_all(folder()); }

  static fs::path& folder() {
    static fs::path folder;
    return folder;
  }
  static std::string out(const std::string& name) { return (folder() / name).string(); }

  static std::string study() { return test::source_path("bringup/studies/quick.yaml"); }
  // Runs `tandem study` with two processes and returns its exit status.
  static int run(std::vector<std::string> words, double timeout = kLong) {
    words.insert(words.begin(), "study");
    if (words[1] != "merge") words.insert(words.end(), {"--jobs", "2"});
    words.emplace_back("--no-report");
    test::ChildProcess program{"../tandem", words};
    return program.wait(timeout).value_or(-1);
  }
  static std::size_t lines(const std::string& name) {
    std::ifstream in{out(name) + "/drives.jsonl", std::ios::binary};
    const std::string text{std::istreambuf_iterator<char>{in}, {}};
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  // The drives without the values measured by a clock.
  static json drives(const std::string& name) {
    std::ifstream in{out(name) + "/drives.json"};
    json drives = json::parse(in);
    for (json& drive : drives)
      for (const char* key : {"wall_s", "cpu_s", "part_s", "plan_ms", "missed_deadlines"})
        drive.erase(key);
    return drives;
  }
};

TEST_F(StudyProgram, WritesAnObjectPerDriveATableAndASummary) {
  const json all = drives("whole");
  ASSERT_EQ(all.size(), kDrives);
  for (const json& drive : all) {
    EXPECT_GT(drive.at("path_length_m"), 0.0);
    EXPECT_GT(drive.at("free_time_s"), 0.0);
    EXPECT_TRUE(drive.at("agreement_direction").is_number());
    EXPECT_TRUE(drive.at("method") == "manual" || drive.at("collisions") == 0) << drive.dump();
    EXPECT_TRUE(drive.at("reached") == false || drive.at("path_ratio") >= 0.98) << drive.dump();
  }
  std::ifstream in{out("whole") + "/summary.json"};
  const json summary = json::parse(in);
  ASSERT_EQ(summary.size(), kGroups);
  for (const json& group : summary) EXPECT_EQ(group.at("n"), 3);
  EXPECT_GT(fs::file_size(out("whole") + "/drives.csv"), 1000u);
  EXPECT_GT(fs::file_size(out("whole") + "/worlds.json"), 1000u);
}

TEST_F(StudyProgram, ResumesAfterAKillWithoutLosingADriveAndEndsWithTheSameResults) {
  {
    test::ChildProcess program{
        "../tandem", {"study", study(), "--out", out("killed"), "--jobs", "2", "--no-report"}};
    while (lines("killed") < kDrives / 6) ASSERT_FALSE(program.wait(0.01).has_value());
    program.send(SIGKILL);
    EXPECT_EQ(program.wait(20.0), 128 + SIGKILL);
  }
  const std::size_t kept = lines("killed");
  EXPECT_LT(kept, kDrives);
  const test::CapturedLog log;
  ASSERT_EQ(run({study(), "--out", out("killed")}), 0);
  EXPECT_EQ(log.lines(std::to_string(kept) + " already finished"), 1) << log.text();
  EXPECT_EQ(lines("killed"), kDrives);
  EXPECT_EQ(drives("killed"), drives("whole"));
}

TEST_F(StudyProgram, MergedShardsEqualTheWhole) {
  for (const std::string shard : {"1", "2", "3"})
    ASSERT_EQ(run({study(), "--out", out("shard" + shard), "--shard", shard + "/3"}), 0);
  EXPECT_EQ(drives("shard2").size(), kDrives / 3);
  ASSERT_EQ(run({"merge", out("merged"), out("shard1"), out("shard2"), out("shard3")}), 0);
  EXPECT_EQ(drives("merged"), drives("whole"));
}

TEST_F(StudyProgram, ReportsInOnePageThatHoldsItsPictures) {
  if (std::system("/usr/bin/python3 -c 'import matplotlib'") != 0)
    GTEST_SKIP() << "NO REPORT TESTED: python3-matplotlib is not installed";
  test::ChildProcess program{"../tandem", {"study", "merge", out("reported"), out("whole")}};
  ASSERT_EQ(program.wait(kLong), 0);
  std::ifstream in{out("reported") + "/report.html"};
  const std::string page{std::istreambuf_iterator<char>{in}, {}};
  for (const char* what : {"<h1>Study quick</h1>", "paths in forest.bt", "data:image/png;base64,",
                           "Devalla 2020: direct", "<h2>corridor</h2>"})
    EXPECT_NE(page.find(what), std::string::npos) << what;
  EXPECT_GT(fs::file_size(out("reported") + "/paths_forest_task2_forest.png"), 10'000u);
}

TEST_F(StudyProgram, RefusesAFolderOfAnotherStudyAndInvalidShards) {
  const fs::path other = folder() / "other.yaml";
  std::ofstream{other} << "study: other\nscenarios: ["
                       << test::source_path("bringup/scenarios/forest_task2.yaml")
                       << "]\nseeds: 1\n";
  {
    const test::CapturedLog log;
    EXPECT_EQ(run({other.string(), "--out", out("whole")}, 30.0), 1);
    EXPECT_EQ(log.lines("contains another study (study differs)"), 1) << log.text();
  }
  for (const std::string shard : {"0/3", "4/3", "1", "a/b", "1/2x"}) {
    const test::CapturedLog log;
    EXPECT_EQ(run({study(), "--out", out("none"), "--shard", shard}, 30.0), 1);
    EXPECT_EQ(log.lines("--shard " + shard + ": expected i/n"), 1) << log.text();
  }
  EXPECT_FALSE(fs::exists(out("none")));
}

TEST_F(StudyProgram, SaysThatADriveIsOfAnotherBuild) {
  fs::copy(out("whole"), out("mixed"));
  std::ifstream in{out("whole") + "/drives.jsonl", std::ios::binary};
  std::string text{std::istreambuf_iterator<char>{in}, {}};
  const std::string key = "\"build\":\"";
  text.replace(text.find(key) + key.size(), 16, "0123456789abcdef");
  std::ofstream{out("mixed") + "/drives.jsonl", std::ios::binary} << text;
  const test::CapturedLog log;
  ASSERT_EQ(run({study(), "--out", out("mixed")}), 0);
  EXPECT_EQ(log.lines("1 of them by another build of tandem"), 1) << log.text();
  const json builds = json::parse(std::ifstream{out("mixed") + "/builds.json"});
  EXPECT_EQ(builds.size(), 2u);
  EXPECT_EQ(builds.at("0123456789abcdef"), 1);
}

// The command fails with one line of explanation before any drive.
void expect_complaint(const std::vector<std::string>& words, const std::string& complaint) {
  const test::CapturedLog log;
  test::ChildProcess program{"../tandem", words};
  EXPECT_EQ(program.wait(30.0), 1) << words.front();
  EXPECT_EQ(log.lines(complaint), 1) << log.text();
}

TEST_F(StudyProgram, AndAllOthersThatDriveRefuseAMisspeltKeyOfARobot) {
  std::ofstream{folder() / "robot.yaml"} << "/**:\n  ros__parameters:\n    a_brk: 1.5\n";
  const std::string scenario = out("misspelt.yaml"), key = "robot.yaml:3: a_brk: unknown parameter";
  std::ofstream{scenario} << "scenario: t\nmap: " << test::source_path("maps/forest.bt")
                          << "\nrobot: robot.yaml\nstart: [-4.0, -4.0, 0.0]\n"
                             "goal: {region: [3.0, 1.5, 5.0, 3.5]}\nmethod: leader\n";
  std::ofstream{out("misspelt_study.yaml")} << "study: t\nscenarios: [misspelt.yaml]\nseeds: 1\n";
  expect_complaint({"scenario", scenario, "--lockstep"}, key);
  expect_complaint({"study", out("misspelt_study.yaml"), "--out", out("none")}, key);
  expect_complaint({"metrics", out("whole"), "--scenario", scenario}, key);
  EXPECT_FALSE(fs::exists(out("none")));
}

TEST_F(StudyProgram, AndScenarioRefusesSeedsThatContradict) {
  const std::string scenario = test::source_path("bringup/scenarios/forest_task2.yaml");
  expect_complaint({"scenario", scenario, "--lockstep", "--seed", "2", "--seeds", "3-4"},
                   "--seed excludes --seeds");
}

TEST_F(StudyProgram, AndAnEmptyArgumentIsAMistake) {
  expect_complaint({"study", study(), "--out", out("none"), "--shard", ""}, "argument 6 is empty");
  EXPECT_FALSE(fs::exists(out("none")));
}

TEST_F(StudyProgram, MergesNoDamagedShardAndSaysWhichItIs) {
  fs::create_directories(out("damaged"));
  std::ofstream{out("damaged") + "/study.json"} << "{}";
  expect_complaint({"study", "merge", out("merged_of_damaged"), out("damaged"), "--no-report"},
                   out("damaged") + "/study.json: is damaged");
  EXPECT_FALSE(fs::exists(out("merged_of_damaged")));
}

}  // namespace
}  // namespace tandem
