// SPDX-License-Identifier: Apache-2.0
// Tests the folder that stores finished drives.
#include "bringup/study/study_folder.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "bringup/study/study.hpp"
#include "bringup/study/study_summary.hpp"
#include "support/instrumented.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

const DriveGroup kGroup{"s", "m", "d"}, kOther{"s", "m2", "d"};
const nlohmann::json kStudy = {
    {"study", "t"},
    {"description", {{"a", 1}}},
    {"groups",
     {{{"scenario", "s"}, {"method", "m"}, {"driver", "d"}, {"seeds", "1-3"}},
      {{"scenario", "s"}, {"method", "m2"}, {"driver", "d"}, {"seeds", "7"}}}}};

nlohmann::json finished(const DriveGroup& group, unsigned seed, double time) {
  DriveResult result;
  result.scenario = group.scenario;
  result.method = group.method;
  result.driver = group.driver;
  result.seed = seed;
  result.time_to_goal_s = time;
  return {{"drive", result},
          {"track", {{1.0, 2.0}}},
          {"contacts", nlohmann::json::array()},
          {"cost_s", 0.5}};
}

std::vector<DriveResult> results_of(const StudyFolder& folder, const DriveGroup& group) {
  std::vector<DriveResult> results;
  folder.results().read(group, [&](const DriveResult& result) { results.push_back(result); });
  return results;
}

class Folder : public ::testing::Test {
 protected:
  Folder() { fs::create_directories(folder_); }
  ~Folder() override { fs::remove_all(folder_); }

  // The error message of opening the folder of a study.
  [[nodiscard]] std::string complaint(const nlohmann::json& study) const {
    try {
      const StudyFolder folder{path_, study};
      return {};
    } catch (const std::exception& error) {
      return error.what();
    }
  }
  const fs::path folder_ =
      fs::temp_directory_path() / ("tandem_study_folder_test_" + std::to_string(getpid()));
  const std::string path_ = (folder_ / "out").string(), file_ = path_ + "/drives.sqlite";
};

TEST_F(Folder, KeepsEveryMeasureOfADriveInTheOrderOfSeeds) {
  auto drive = finished(kGroup, 1, 0.1 + 0.2).at("drive").get<DriveResult>();
  drive.lockstep = drive.reached = true;
  drive.walked_into = 2;
  drive.path_ratio = 1.0 / 3.0;
  drive.part_s.planner = 4.0;
  drive.plan_ms.p99 = 1e-300;
  drive.counts.plans = 1'000'000'000'000;
  drive.failures = {"it's", "\"two\""};
  auto stored = finished(kGroup, 1, 0.0);
  stored["drive"] = drive;
  {
    StudyFolder folder{path_, kStudy};
    folder.results().add(finished(kGroup, 3, 3.0));
    folder.results().add(stored);
  }
  const StudyFolder folder{path_, kStudy};
  EXPECT_EQ(folder.planned(), 4u);
  EXPECT_EQ(folder.results().size(), 2u);
  EXPECT_EQ(folder.results().cost(), 1.0);
  EXPECT_TRUE(folder.results().contains(kGroup, 1));
  EXPECT_FALSE(folder.results().contains(kGroup, 2));
  EXPECT_FALSE(folder.results().contains(kOther, 1));
  const auto results = results_of(folder, kGroup);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(nlohmann::json(results[0]), stored.at("drive"));
  EXPECT_EQ(results[1].time_to_goal_s, 3.0);
}

TEST_F(Folder, KeepsTheFirstOfTwoDrivesOfOneName) {
  StudyFolder folder{path_, kStudy}, same{path_, kStudy};
  folder.results().add(finished(kGroup, 1, 1.0));
  same.results().add(finished(kGroup, 1, 2.0), {"another build", "another machine"});
  const auto results = results_of(folder, kGroup);
  ASSERT_EQ(results.size(), 1u);
  EXPECT_EQ(results[0].time_to_goal_s, 1.0);
}

TEST_F(Folder, RefusesADriveWithoutANumber) {
  StudyFolder folder{path_, kStudy};
  auto drive = finished(kGroup, 1, 1.0);
  drive["drive"]["wall_s"] = nullptr;  // as JSON writes what is not a number
  EXPECT_THROW(folder.results().add(drive), std::runtime_error);
  EXPECT_EQ(folder.results().size(), 0u);
}

TEST_F(Folder, AddsTheDrivesOfAnotherThatItLacks) {
  StudyFolder folder{path_, kStudy}, other{path_ + "2", kStudy};
  folder.results().add(finished(kGroup, 1, 1.0));
  other.results().add(finished(kGroup, 1, 9.0));
  other.results().add(finished(kOther, 7, 7.0), {"another build", "another machine"});
  for (const int twice : {1, 2}) {
    folder.results().add_all_of(other.results());
    EXPECT_EQ(folder.results().size(), 2u) << twice;
  }
  EXPECT_EQ(results_of(folder, kGroup).front().time_to_goal_s, 1.0);
  EXPECT_EQ(results_of(folder, kOther).front().time_to_goal_s, 7.0);
  std::set<std::string> builds;
  for (const auto& origin : origins_of(folder)) builds.insert(origin.at("build"));
  EXPECT_EQ(builds, (std::set<std::string>{this_origin().build, "another build"}));
}

// Several workers of one shard, all of which drive the same.
TEST_F(Folder, IsWrittenByManyProcessesAtOnceAndLosesNothing) {
  constexpr unsigned kWorkers = 4, kSeeds = 25;
  std::vector<pid_t> workers;
  for (unsigned w = 0; w < kWorkers; ++w) {
    workers.push_back(fork());
    if (workers.back() != 0) continue;
    try {
      StudyFolder folder{path_, kStudy};
      for (unsigned i = 0; i < kSeeds; ++i) {
        const unsigned seed = 1 + (i + 5 * w) % kSeeds;
        folder.results().add(finished(kGroup, seed, seed));
      }
      std::_Exit(0);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      std::_Exit(1);
    }
  }
  for (const pid_t worker : workers) {
    int status = -1;
    waitpid(worker, &status, 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(results_of({path_, kStudy}, kGroup).size(), kSeeds);
}

TEST_F(Folder, RefusesAnotherStudyAndSaysWhatDiffers) {
  EXPECT_EQ(complaint(kStudy), "");
  auto other = kStudy;
  other["description"]["a"] = 2;
  EXPECT_NE(complaint(other).find("contains another study (a differs)"), std::string::npos);
}

TEST_F(Folder, RefusesTheLinesOfAnOlderTandem) {
  fs::create_directories(path_);
  std::ofstream{path_ + "/study.json"} << R"({"study": "t", "description": {}, "drives": ["one"]})";
  std::ofstream{path_ + "/drives.jsonl"} << "{}\n";
  EXPECT_EQ(complaint(kStudy),
            path_ +
                "/drives.jsonl: is of an older tandem, and this one cannot read it; choose "
                "another folder");
  EXPECT_THROW((void)read_study(path_), std::runtime_error);
}

TEST_F(Folder, RefusesTheColumnsOfAnotherVersion) {
  EXPECT_EQ(complaint(kStudy), "");
  {
    const auto database = create_database(file_, "a test's");
    sql::execute(database, "ALTER TABLE drives RENAME COLUMN wall_s TO old_wall_s");
  }
  EXPECT_EQ(complaint(kStudy),
            file_ + ": drives of another version of tandem; choose another folder");
}

TEST_F(Folder, NamesADamagedStudyDescriptionAndItsRemedy) {
  const std::string file = path_ + "/study.json";
  (StudyFolder{path_, kStudy}).results().add(finished(kGroup, 1, 1.0));
  for (const char* text : {"", "{", "[]", "{}", R"({"study": "t", "description": {}})",
                           R"({"study": "t", "description": [], "groups": []})",
                           R"({"study": "t", "description": {}, "groups": [1]})",
                           R"({"study": "t", "description": {}, "groups":
            [{"scenario": "s", "method": "m", "driver": "d", "seeds": "1-x"}]})"}) {
    std::ofstream{file} << text;
    for (const bool opened : {false, true}) try {
        opened ? (void)StudyFolder(path_, kStudy) : (void)read_study(path_);
        ADD_FAILURE() << "took " << text;
      } catch (const std::runtime_error& error) {
        const std::string line = error.what();
        EXPECT_TRUE(line.starts_with(file + ": is damaged: it does not describe a study")) << line;
        EXPECT_NE(line.find("remove this file"), std::string::npos) << line;
      }
  }
  fs::remove(file);  // as it says
  EXPECT_EQ((StudyFolder{path_, kStudy}.results().size()), 1u);
  EXPECT_EQ(read_study(path_), kStudy);
}

TEST_F(Folder, NamesDamagedResults) {
  fs::create_directories(path_);
  std::ofstream{file_} << std::string(20'000, 'x');
  EXPECT_EQ(complaint(kStudy), file_ + ": file is not a database; is it the results of a study?");
}
}  // namespace
}  // namespace tandem
