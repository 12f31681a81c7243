// SPDX-License-Identifier: Apache-2.0
// Runs the program as a user does: scenarios in lockstep, and its messages for bad input.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <sstream>
#include <string>

#include "support/captured_log.hpp"
#include "support/instrumented.hpp"
#include "support/paths.hpp"
#include "system/scenario_program.hpp"

namespace tandem::test {
namespace {

namespace fs = std::filesystem;

TEST_F(ScenarioProgram, SameSeedGivesTheSameDriveBitForBit) {
  // Planned drives take a minute each where a sanitizer watches.
  const std::vector<std::string> options{"--lockstep", "--seed", "3", "--method",
                                         kInstrumented ? "safety_filter" : "leader"};
  ASSERT_EQ(run("forest_task2", options), 0);
  const auto first = json().at(0);
  ASSERT_EQ(run("forest_task2", options), 0);
  const auto second = json().at(0);
  for (const char* key : {"time_to_goal_s", "min_clearance_m", "path_length_m", "obedience_rms"})
    EXPECT_EQ(first.at(key).get<double>(), second.at(key).get<double>()) << key;
}

TEST_F(ScenarioProgram, WritesEveryMeasureItPromises) {
  ASSERT_EQ(run("forest_task2", {"--lockstep", "--method", "safety_filter"}), 0);
  const auto drive = json().at(0);
  for (const char* key :
       {"scenario", "map", "method", "driver", "seed", "lockstep", "reached", "time_to_goal_s",
        "simulated_s", "wall_s", "collisions", "min_clearance_m", "path_length_m", "obedience_rms",
        "filter_interventions", "stuck_s", "final_position_error_m", "plan_ms", "plan_fallbacks"})
    EXPECT_TRUE(drive.contains(key)) << key;
  for (const char* key : {"p50", "p95", "p99", "max"})
    EXPECT_TRUE(drive.at("plan_ms").at(key).is_number()) << key;
}

TEST_F(ScenarioProgram, TheLastPictureFolderNamedIsTheOneThatCounts) {
  const fs::path first = folder_ / "first", last = folder_ / "last";
  ASSERT_EQ(run("forest_task2", {"--lockstep", "--method", "safety_filter", "--picture",
                                 first.string(), "--picture", last.string()}),
            0);
  EXPECT_TRUE(fs::exists(last / "forest_task2_safety_filter_1.png"));
  EXPECT_FALSE(fs::exists(first));
}

TEST_F(ScenarioProgram, ExitsWithOneWhenWhatMustHoldDidNot) {
  const fs::path file = folder_ / "impossible.yaml";
  std::ofstream{file} << "scenario: impossible\nmap: " << source_path("maps/forest.bt")
                      << "\nrobot: " << source_path("bringup/robots/mir100.yaml")
                      << "\nstart: [-4, -4, 0]\ngoal: {region: [3, 1.5, 5, 3.5]}\n"
                         "method: safety_filter\nduration: 1\n"
                         "parameters: {driver: {route: [4, 2.5]}}\n";
  ChildProcess program{"../tandem", {"scenario", file.string(), "--lockstep"}};
  EXPECT_EQ(program.wait(20.0), 1);
}

TEST_F(ScenarioProgram, RefusesFilesThatAreNotThere) {
  EXPECT_EQ(run("nowhere", {"--lockstep"}, 20.0), 1);
  EXPECT_EQ(run("forest_task2", {"--lockstep", "--map", "/nowhere.bt"}, 20.0), 1);
  for (const char* command : {"run", "map"}) {
    ChildProcess program{"../tandem", {command, "/nowhere.yaml"}};
    EXPECT_EQ(program.wait(20.0), 1) << command;
  }
}

struct BadOption {
  const char* name;
  std::vector<std::string> words;
  const char* complaint;
};

class BadOptions : public ScenarioProgram, public ::testing::WithParamInterface<BadOption> {};

TEST_P(BadOptions, AreRefusedInOneLineBeforeAnythingMoves) {
  const CapturedLog log;
  EXPECT_EQ(run("forest_task2", GetParam().words, 20.0), 1);
  EXPECT_NE(log.text().find(GetParam().complaint), std::string::npos) << log.text();
  EXPECT_EQ(log.lines("tandem: "), 1) << log.text();
  EXPECT_FALSE(fs::exists(json_file()));
}

INSTANTIATE_TEST_SUITE_P(
    Words, BadOptions,
    ::testing::Values(
        BadOption{"method", {"--lockstep", "--method", "magic"}, "method `magic` is not one of"},
        BadOption{"goal_without_pose", {"--method", "goal"}, "method `goal` needs goal: {pose:"},
        BadOption{"seed", {"--lockstep", "--seed", "4294967295"}, "above the largest, 2147483647"},
        BadOption{"seeds", {"--lockstep", "--seeds", "1-2x"}, "--seeds 1-2x: expected N or A-B"},
        BadOption{"no_seeds", {"--lockstep", "--seeds", "0"}, "--seeds 0: expected N or A-B"},
        BadOption{"many_seeds", {"--lockstep", "--seeds", "1-4000000000"}, "100000 at most"},
        BadOption{"speed", {"--speed", "0"}, "speed_factor = 0 outside"},
        BadOption{"picture", {"--picture", "/dev/null"}, "--picture /dev/null: "}),
    [](const auto& test) { return std::string(test.param.name); });

TEST_F(ScenarioProgram, KnowsBeforeTheDriveThatItsResultCannotBeWritten) {
  const CapturedLog log;
  ChildProcess program{"../tandem",
                       {"scenario", source_path("bringup/scenarios/forest_task2.yaml"), "--json",
                        "/no/such/folder.json"}};
  EXPECT_EQ(program.wait(20.0), 1);
  EXPECT_EQ(log.lines("--json /no/such/folder.json: cannot be written"), 1) << log.text();
}

TEST_F(ScenarioProgram, NamesACommandThatDoesNotExist) {
  const CapturedLog log;
  for (const auto& words : std::vector<std::vector<std::string>>{{"scenarios"}, {"map", "draw"}}) {
    ChildProcess program{"../tandem", words};
    EXPECT_EQ(program.wait(20.0), 1);
    EXPECT_EQ(log.lines("tandem: no command '" + words.back() + "'"), 1) << log.text();
  }
}

class BrokenScenarioMap : public ScenarioProgram,
                          public ::testing::WithParamInterface<const char*> {};

TEST_P(BrokenScenarioMap, IsOneErrorAndExitStatusOne) {
  const fs::path map = folder_ / "broken.bt";
  const std::string kind = GetParam();
  if (kind == "empty") std::ofstream{map};
  if (kind == "text") std::ofstream{map} << "not a map\n";
  if (kind == "truncated") {
    std::ifstream in{source_path("maps/forest.bt"), std::ios::binary};
    std::string bytes{std::istreambuf_iterator<char>{in}, {}};
    std::ofstream{map, std::ios::binary} << bytes.substr(0, bytes.size() / 2);
  }
  EXPECT_EQ(run("forest_task2", {"--lockstep", "--map", map.string()}, 20.0), 1);
  EXPECT_EQ(run("forest_task2", {"--dds", "--map", map.string()}, 20.0), 1);
}

INSTANTIATE_TEST_SUITE_P(Files, BrokenScenarioMap, ::testing::Values("empty", "text", "truncated"),
                         [](const auto& test) { return std::string(test.param); });

// What a command prints.
std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> out{popen(command.c_str(), "r"), pclose};
  std::string text;
  for (char part[100]; out && std::fgets(part, sizeof part, out.get()) != nullptr;) text += part;
  return text;
}

// Everything that `tandem list` finds, `tandem describe` must know.
TEST(Program, DescribesEachComponentThatItLists) {
  std::istringstream list{output_of("../tandem list")};
  int components = 0;
  for (std::string name; std::getline(list, name); ++components) {
    const std::string text = output_of("../tandem describe " + name);
    EXPECT_TRUE(text.starts_with(name + "\n")) << name;
    EXPECT_NE(text.find("\n  parameter "), std::string::npos) << name;
  }
  EXPECT_GE(components, 14);
}

TEST(Program, DescribesTopicsWithTypeAndQos) {
  std::string text = output_of("../tandem describe safety_filter");
  const auto has = [&](const std::string& line) { return text.find(line) != std::string::npos; };
  text.erase(
      std::unique(text.begin(), text.end(), [](char a, char b) { return a == ' ' && b == ' '; }),
      text.end());  // columns
  EXPECT_TRUE(
      has("\n cmd_vel geometry_msgs/msg/Twist reliable, volatile, depth 1, lifespan 0.2 s "
          "if stamped: false\n"))
      << text;
  EXPECT_TRUE(has("\n odom nav_msgs/msg/Odometry reliable, volatile, depth 10, or weaker\n"))
      << text;
}

TEST(Program, DescribesAComponentOfAThirdParty) {
  const std::string folder = binary_path("tests");
  const std::string text =
      output_of("TANDEM_COMPONENT_PATH=" + folder + " ../tandem describe test_component");
  for (const char* part : {"std_msgs/msg/Float64", "reliable, transient local, depth 1", "factor"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
}

}  // namespace
}  // namespace tandem::test
