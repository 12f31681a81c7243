// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <regex>
#include <stdexcept>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(Balanced, GivesShardsOfNearlyEqualCost) {
  std::vector<double> costs;
  for (int i = 0; i < 500; ++i) costs.push_back(1.0 + i % 37);
  const auto shard_of = balanced(costs, 8);
  std::vector<double> load(8, 0.0);
  for (std::size_t i = 0; i < costs.size(); ++i) load.at(shard_of[i]) += costs[i];
  const auto [least, most] = std::minmax_element(load.begin(), load.end());
  EXPECT_LE(*most - *least, 1.0);  // the cheapest drive, which is dealt last
}

// Two methods, of which one costs ten times as much.
class StudyPlan : public ::testing::Test {
 protected:
  StudyPlan() {
    std::ofstream{file_} << "study: it's mine\nscenarios: ["
                         << test::source_path("bringup/scenarios/forest_task2.yaml")
                         << "]\nmethods: [manual, leader]\nseeds: 20\n";
    study_ = load_study(file_);
    todo_.resize(study_.drives.size());
    std::iota(todo_.begin(), todo_.end(), std::size_t{0});
  }

  // A folder in which seed 1 of each method is finished.
  [[nodiscard]] StudyFolder folder() const {
    StudyFolder folder{out_, contents_of(study_)};
    for (const std::size_t i : todo_) {
      if (study_.drives[i].seed != 1) continue;
      const DriveGroup group = group_of(study_, study_.drives[i]);
      DriveResult result;
      result.scenario = group.scenario;
      result.method = group.method;
      result.driver = group.driver;
      result.seed = 1;
      folder.results().add({{"drive", result},
                            {"track", json::array()},
                            {"contacts", json::array()},
                            {"cost_s", group.method == "leader" ? 10.0 : 1.0}});
    }
    return folder;
  }
  [[nodiscard]] std::string complaint(const std::string& plan, std::size_t shards) const {
    try {
      (void)drives_of_shard(study_, plan, 1, shards);
      return {};
    } catch (const std::exception& error) {
      return error.what();
    }
  }
  // The files that write_plan() writes for 4 shards.
  void write() const { write_plan(plan_of(study_, folder(), todo_, 4), file_, out_); }
  [[nodiscard]] std::string text(const std::string& name) const {
    std::ifstream in{out_ + "/" + name};
    return {std::istreambuf_iterator<char>{in}, {}};
  }

  test::TemporaryFolder folder_;
  const std::string file_ = folder_.path() / "it's.yaml", out_ = folder_.path() / "my out";
  Study study_;
  std::vector<std::size_t> todo_;
};

TEST_F(StudyPlan, SamplesEachGroupOnceUntilItsCostIsKnown) {
  const StudyFolder empty{folder_.path() / "empty", contents_of(study_)};
  const auto sample = sample_of(study_, empty, todo_);
  EXPECT_EQ(sample, (std::vector<std::size_t>{0, 20}));
  EXPECT_TRUE(sample_of(study_, folder(), {1, 2, 21, 22}).empty());
}

TEST_F(StudyPlan, SharesOutEachDriveOnceWithEqualCosts) {
  const json plan = plan_of(study_, folder(), todo_, 4);
  write_file(folder_.path() / "p.json", plan.dump());
  std::vector<std::size_t> all;
  for (std::size_t shard = 1; shard <= 4; ++shard) {
    EXPECT_NEAR(plan.at("shards")[shard - 1].at("cost_s").get<double>(), 220.0 / 4, 1e-9);
    const auto own = drives_of_shard(study_, folder_.path() / "p.json", shard, 4);
    all.insert(all.end(), own.begin(), own.end());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, todo_);
}

TEST_F(StudyPlan, IsRefusedIfItIsOfAnotherStudyOrDamaged) {
  write();
  EXPECT_EQ(complaint(out_ + "/plan.json", 4), "");
  EXPECT_EQ(complaint(out_ + "/plan.json", 5),
            out_ + "/plan.json: has 4 shards, not 5; name one of them: --shard 1/4");
  EXPECT_NE(
      complaint(out_ + "/none.json", 4).find("no such file; write it with `tandem study plan`"),
      std::string::npos);
  json other = json::parse(text("plan.json"));
  other["description"]["study"] = "another";
  write_file(out_ + "/other.json", other.dump());
  EXPECT_NE(complaint(out_ + "/other.json", 4).find("of another study (study differs)"),
            std::string::npos);
  write_file(out_ + "/damaged.json", "{");
  EXPECT_NE(complaint(out_ + "/damaged.json", 4).find("is not a plan"), std::string::npos);
  other["description"]["study"] = "it's mine";
  other["shards"][0]["drives"] = {{"a/b/c", "1-x"}};
  write_file(out_ + "/damaged.json", other.dump());
  EXPECT_NE(complaint(out_ + "/damaged.json", 4).find("is damaged: `x` is not a seed"),
            std::string::npos);
}

TEST_F(StudyPlan, GivesThreeTimesTheLongestShardAndTenMinutes) {
  EXPECT_EQ(time_limit({{"shards", {{{"cost_s", 60.0}}, {{"cost_s", 1200.0}}}}}), 70);
}

// Runs a command on the plan's files and returns its status.
int run(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()); }

TEST_F(StudyPlan, WritesScriptsThatSlurmAndTheShellRead) {
  write();
  EXPECT_EQ(run("bash -n '" + out_ + "/shards.sbatch' && bash -n '" + out_ + "/merge.sbatch'"), 0);
  const std::string shards = text("shards.sbatch");
  const auto commands = shards.find("\ntandem=");
  const std::vector<std::string> options{
      "--job-name=tandem_it_s_mine",
      "--array=1-4",
      "--time=12",
      "--requeue",
      "--open-mode=append",
      "--output=\"" + fs::canonical(out_).string() + "/logs/shard_%a.log\""};
  for (const auto& option : options)
    EXPECT_LT(shards.find("\n#SBATCH " + option + "\n"), commands) << option;
  EXPECT_TRUE(fs::is_directory(out_ + "/logs"));
}

// A program that notes its arguments runs instead of tandem.
TEST_F(StudyPlan, ItsScriptDrivesTheShardOfItsTask) {
  write();
  const std::string noted = folder_.path() / "noted";
  std::ofstream{folder_.path() / "tandem"} << "#!/bin/sh\nprintf '%s\\n' \"$@\" >" << noted << "\n";
  fs::permissions(folder_.path() / "tandem", fs::perms::owner_all);
  std::string script = text("shards.sbatch");
  const auto program = script.find("\ntandem=") + 1;
  script.replace(program, script.find('\n', program) - program,
                 "tandem=" + (folder_.path() / "tandem").string());
  write_file(folder_.path() / "script", script);
  ASSERT_EQ(run("SLURM_ARRAY_TASK_ID=3 bash " + (folder_.path() / "script").string()), 0);
  std::ifstream in{noted};
  const std::string words{std::istreambuf_iterator<char>{in}, {}}, out = fs::canonical(out_);
  EXPECT_EQ(words, "study\n" + file_ + "\n--plan\n" + out + "/plan.json\n--shard\n3/4\n--out\n" +
                       out + "/shards/3\n--jobs\n1\n--no-report\n");
}

TEST_F(StudyPlan, ItsScriptRequeuesAfterAnErrorTwice) {
  write();
  const std::string folder = folder_.path(), noted = folder + "/noted";
  std::ofstream{folder + "/scontrol"} << "#!/bin/sh\necho \"$@\" >>" << noted << "\nexit 1\n";
  fs::permissions(folder + "/scontrol", fs::perms::owner_all);
  const std::string environment =
      "PATH=" + folder + ":/usr/bin:/bin SLURM_ARRAY_JOB_ID=9 SLURM_ARRAY_TASK_ID=3 ";
  write_file(folder + "/script", std::regex_replace(text("shards.sbatch"),
                                                    std::regex{"\ntandem=.*"}, "\ntandem=false"));
  for (const char* restarts : {"", "SLURM_RESTART_COUNT=1 ", "SLURM_RESTART_COUNT=2 "})
    EXPECT_NE(run(environment + restarts + "bash " + folder + "/script"), 0);
  std::ifstream in{noted};
  const std::string words{std::istreambuf_iterator<char>{in}, {}};
  EXPECT_EQ(words, "requeue 9_3\nrequeue 9_3\n");
}

TEST_F(StudyPlan, WritesASnakefileThatSnakemakePlansWith) {
  write();
  const std::string snakefile = text("Snakefile");
  for (const char* rule : {"rule shard:", "rule merge:", "rule report:"})
    EXPECT_NE(snakefile.find(rule), std::string::npos) << rule;
  if (run("/usr/bin/snakemake --version") != 0)
    GTEST_SKIP() << "NOT TESTED: the Snakefile of a plan: snakemake is not installed";
  EXPECT_EQ(
      run("cd '" + out_ + "' && /usr/bin/snakemake --dryrun --cores 1 | grep -Eq '^shard +4 '"), 0);
}

}  // namespace
}  // namespace tandem
