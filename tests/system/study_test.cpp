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
#include <stdexcept>
#include <string>
#include <vector>

#include "bringup/sqlite/sqlite_database.hpp"
#include "support/captured_log.hpp"
#include "support/child_process.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kDrives = 24, kGroups = 8;
constexpr double kStudyTimeout = 300.0;  // [s] for a sanitizer on a busy machine

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
  // A study of 8 short drives.
  static fs::path write_short_study() {
    const fs::path file = folder() / "short.yaml";
    std::ofstream{file} << "study: short\nscenarios: [{file: "
                        << test::source_path("bringup/scenarios/forest_task2.yaml")
                        << ", duration: 3}]\nmethods: [manual, leader]\nseeds: 4\n";
    return file;
  }
  // Runs `tandem study` with two processes and returns its exit status.
  static int run(std::vector<std::string> words, double timeout = kStudyTimeout) {
    words.insert(words.begin(), "study");
    if (words[1] != "merge") words.insert(words.end(), {"--jobs", "2"});
    words.emplace_back("--no-report");
    test::ChildProcess program{"../tandem", words};
    return program.wait(timeout).value_or(-1);
  }
  // Number of finished drives; 0 as long as there is no file of them.
  static std::size_t finished(const std::string& name) {
    try {
      return static_cast<std::size_t>(std::stoul(first_value(name, "SELECT count(*) FROM drives")));
    } catch (const std::runtime_error&) {
      return 0;
    }
  }
  // The first value of a query, or statement, on the drives of a folder.
  static std::string first_value(const std::string& name, const std::string& query) {
    if (!fs::exists(out(name) + "/drives.sqlite")) throw std::runtime_error("no drives");
    const auto database = create_database(out(name) + "/drives.sqlite", "the results of a study");
    const auto row = sql::prepare(database, query);
    return sql::step(database, row) ? sql::text(row, 0) : "";
  }
  // The drives without the values measured by a clock.
  static json drives(const std::string& name) {
    std::ifstream in{out(name) + "/drives.json"};
    json drives = json::parse(in);
    for (json& drive : drives) {
      for (const char* key : {"wall_s", "cpu_s", "part_s", "plan_ms", "missed_deadlines"})
        drive.erase(key);
      drive["map"] = fs::path{drive["map"].get<std::string>()}.filename();  // relative to where
    }
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
    while (finished("killed") < kDrives / 6) ASSERT_FALSE(program.wait(0.01).has_value());
    program.send(SIGKILL);
    EXPECT_EQ(program.wait(20.0), 128 + SIGKILL);
  }
  const std::size_t kept = finished("killed");
  EXPECT_LT(kept, kDrives);
  const test::CapturedLog log;
  ASSERT_EQ(run({study(), "--out", out("killed")}), 0);
  EXPECT_EQ(log.lines(std::to_string(kept) + " already finished"), 1) << log.text();
  EXPECT_EQ(finished("killed"), kDrives);
  EXPECT_EQ(drives("killed"), drives("whole"));
}

TEST_F(StudyProgram, MergedShardsEqualTheWhole) {
  for (const std::string shard : {"1", "2", "3"})
    ASSERT_EQ(run({study(), "--out", out("shard" + shard), "--shard", shard + "/3"}), 0);
  EXPECT_EQ(drives("shard2").size(), kDrives / 3);
  ASSERT_EQ(run({"merge", out("merged"), out("shard1"), out("shard2"), out("shard3")}), 0);
  EXPECT_EQ(drives("merged"), drives("whole"));
}

TEST_F(StudyProgram, SaysWhatItWillCostAndHowManyDrivesACpuHourMade) {
  const fs::path file = write_short_study();
  const test::CapturedLog log;
  ASSERT_EQ(run({file, "--out", out("short")}), 0);
  EXPECT_EQ(log.lines("short: 8 drives cost about "), 1) << log.text();
  EXPECT_EQ(log.lines(" drives per CPU hour"), 1) << log.text();
  EXPECT_GT(std::stod(first_value("short", "SELECT min(cost_s) FROM drives")), 0.0);
}

// Two workers take the first shard at the same time, one is killed, and the second shard is driven
// twice: nothing is lost.
TEST_F(StudyProgram, PlansShardsThatAreDrivenInAnyWay) {
  const fs::path file = write_short_study();
  ASSERT_EQ(run({file, "--out", out("unplanned")}), 0);
  test::ChildProcess planner{"../tandem",
                             {"study", "plan", file, "--jobs", "2", "--out", out("planned")}};
  ASSERT_EQ(planner.wait(kStudyTimeout), 0);
  const auto shard = [&](const std::string& number) {
    return std::vector<std::string>{
        "study",   file,          "--plan",     out("planned") + "/plan.json",
        "--shard", number + "/2", "--out",      out("planned") + "/shards/" + number,
        "--jobs",  "1",           "--no-report"};
  };
  {
    test::ChildProcess one{"../tandem", shard("1")}, same{"../tandem", shard("1")},
        killed{"../tandem", shard("1")};
    while (finished("planned/shards/1") == 0) ASSERT_FALSE(killed.wait(0.01).has_value());
    killed.send(SIGKILL);
    EXPECT_EQ(one.wait(kStudyTimeout), 0);
    EXPECT_EQ(same.wait(kStudyTimeout), 0);
  }
  for (const int times : {1, 2}) {
    test::ChildProcess other{"../tandem", shard("2")};
    EXPECT_EQ(other.wait(kStudyTimeout), 0) << times;
  }
  EXPECT_EQ(finished("planned/shards/1") + finished("planned/shards/2") + finished("planned"), 8u);
  ASSERT_EQ(run({"merge", out("planned"), out("planned/shards/1"), out("planned/shards/2")}), 0);
  EXPECT_EQ(drives("planned"), drives("unplanned"));
}

// As on another machine: the same build in another folder, run from a third one, in another
// environment, language and time zone, and with another number of processes.
TEST_F(StudyProgram, DrivesTheSameInAnotherCheckoutAndEnvironment) {
  const std::string copy = out("another checkout");
  fs::create_directories(copy + "/share");
  fs::create_directories(copy + "/somewhere");
  ASSERT_EQ(std::system(("cp ../tandem ../libtandem* '" + copy + "' && cp -rL ../share/tandem '" +
                         copy + "/share'")
                            .c_str()),
            0);
  ASSERT_EQ(std::system(("cd '" + copy +
                         "/somewhere' && env -i HOME=/nowhere LC_ALL=de_DE.UTF-8 TZ=Asia/Kolkata "
                         "MALLOC_PERTURB_=170 ../tandem study quick --out '" +
                         out("elsewhere") + "' --jobs 3 --no-report >/dev/null 2>&1")
                            .c_str()),
            0);
  EXPECT_EQ(drives("elsewhere"), drives("whole"));
  const std::string tracks =
      "SELECT group_concat(track || contacts) FROM (SELECT * FROM tracks ORDER BY scenario, method,"
      " driver, seed)";
  EXPECT_EQ(first_value("elsewhere", tracks), first_value("whole", tracks));
  const std::string origin = "SELECT DISTINCT build || machine FROM drives";
  EXPECT_EQ(first_value("elsewhere", origin), first_value("whole", origin));
}

TEST_F(StudyProgram, ReportsInOnePageThatHoldsItsPictures) {
  if (std::system("/usr/bin/python3 -c 'import matplotlib'") != 0)
    GTEST_SKIP() << "NO REPORT TESTED: python3-matplotlib is not installed";
  test::ChildProcess program{"../tandem", {"study", "merge", out("reported"), out("whole")}};
  ASSERT_EQ(program.wait(kStudyTimeout), 0);
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
  (void)first_value("mixed",
                    "UPDATE drives SET build = '0123456789abcdef'"
                    " WHERE scenario = 'corridor' AND method = 'leader' AND seed = 2");
  const test::CapturedLog log;
  ASSERT_EQ(run({study(), "--out", out("mixed")}), 0);
  EXPECT_EQ(log.lines("1 of them by another build of tandem"), 1) << log.text();
  const json origins = json::parse(std::ifstream{out("mixed") + "/origins.json"});
  ASSERT_EQ(origins.size(), 2u);
  EXPECT_EQ(origins[0].at("drives"), kDrives - 1);
  EXPECT_EQ(origins[1].at("build"), "0123456789abcdef");
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
