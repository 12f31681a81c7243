// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/system.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "bringup/system/processes.hpp"
#include "support/child_process.hpp"
#include "support/private_domain.hpp"
#include "support/real_time.hpp"
#include "support/spin_until.hpp"

namespace tandem {
namespace {

using std_msgs::msg::Float64;
using test::ChildProcess;
using test::children_of;
using test::spin_until;

constexpr double kTimeout = 20.0;  // [s]

const std::string kTwoDoublers = R"(use_sim_time: false
components:
  - {component: test_component, name: first, remappings: {in: a, out: b}}
  - {component: test_component, name: second, parameters: {factor: 5.0}, remappings: {in: b, out: c}}
)";

// Threads of this process with that name.
int threads_named(const std::string& name) {
  int count = 0;
  for (const auto& task : std::filesystem::directory_iterator{"/proc/self/task"}) {
    std::string found;
    std::getline(std::ifstream{task.path() / "comm"}, found);
    count += found == name ? 1 : 0;
  }
  return count;
}

class SystemFile : public testing::Test {
 protected:
  std::string write(const std::string& yaml) {
    std::ofstream{path_} << yaml;
    return path_;
  }

  void expect_complaint(const std::string& yaml, const std::vector<std::string>& parts) {
    try {
      (void)load_system(write(yaml));
      ADD_FAILURE() << "accepted:\n" << yaml;
    } catch (const std::invalid_argument& error) {
      const std::string text = error.what();
      for (const auto& part : parts) EXPECT_NE(text.find(part), std::string::npos) << text;
    }
  }

  // The error with which a system of separate processes is refused before any of them starts.
  std::string refusal_of(const std::string& yaml) {
    std::string text;
    try {
      (void)run_system(write(yaml), {}, true, {});
      ADD_FAILURE() << "started";
    } catch (const std::invalid_argument& error) {
      text = error.what();
    }
    EXPECT_TRUE(children_of(getpid()).empty());
    return text;
  }

  // Publishes 1 into the chain until the result arrives at its end.
  bool chain_answers() {
    double result = 0.0;
    const auto in = node_.create_publisher(rt::Topic<Float64>{"a"});
    const auto out = node_.create_subscription(rt::Topic<Float64>{"c"},
                                               [&](const Float64& m) { result = m.data(); });
    Float64 one;
    one.data(1.0);
    const auto timer = node_.create_wall_timer(0.02, [&] { in.publish(one); });
    return spin_until([&] { return result == 10.0; }, kTimeout, node_);
  }

  // Waits until the topic has this many subscriptions.
  bool heard(const char* topic, int listeners) {
    const auto publisher = node_.create_publisher(rt::Topic<Float64>{topic});
    return spin_until([&] { return publisher.matched() == listeners; }, kTimeout, node_);
  }

  std::string path_ = testing::TempDir() + "system_" + std::to_string(getpid()) + ".yaml";
  rt::Node node_{"tester"};
};

bool gone(pid_t pid) { return kill(pid, 0) != 0; }

TEST_F(SystemFile, IsReadWithPathsRelativeToIt) {
  const std::string robot = path_ + ".robot";
  std::ofstream{robot} << "/**: {ros__parameters: {}}\n";
  const System system = load_system(
      write("use_sim_time: true\nparameter_files: [" + robot.substr(robot.rfind('/') + 1) +
            ", jackal]\ncomponents:\n  - {component: c, "
            "namespace: /n, parameters: {text: \"7\", list: [1, 2]}, remappings: {p: q}}\n"));
  std::remove(robot.c_str());
  ASSERT_EQ(system.nodes.size(), 1U);
  const auto& options = system.nodes[0].options;
  EXPECT_EQ(system.nodes[0].component, "c");
  EXPECT_EQ(options.name, "c");
  EXPECT_EQ(options.ns, "/n");
  EXPECT_TRUE(options.use_sim_time);
  EXPECT_EQ(options.parameters.files.at(0), robot);
  EXPECT_TRUE(options.parameters.files.at(1).ends_with("share/tandem/bringup/robots/jackal.yaml"));
  EXPECT_EQ(options.parameters.values.at("text").yaml, "\"7\"");
  EXPECT_EQ(options.parameters.values.at("text").origin, path_ + ":4");
  EXPECT_EQ(options.remappings.at("p"), "q");
}

TEST_F(SystemFile, ErrorsNameTheLine) {
  const std::string head = "components:\n  - ";
  expect_complaint("component: []\n",
                   {path_ + ":1", "unknown key `component`", "did you mean `components`?"});
  expect_complaint(head + "{component: c, nam: x}\n",
                   {path_ + ":2", "unknown key `components[0].nam`", "did you mean `name`?"});
  expect_complaint(head + "{name: x}\n", {path_ + ":2", "`components[0].component` is missing"});
  expect_complaint(head + "c\n", {path_ + ":2: `components[0]`: expected `key: value` lines"});
  expect_complaint("components: []\n", {"no components"});
  expect_complaint("parameter_files: [nix.yaml]\n",
                   {path_ + ":1", "nix.yaml: no such file", "Tandem's own robots are", "jackal"});
  expect_complaint("components: [\n", {path_});
  EXPECT_THROW((void)load_system("/nowhere.yaml"), std::invalid_argument);
}

TEST_F(SystemFile, RunsInThisProcess) {
  RunningSystem system{load_system(write(kTwoDoublers))};
  EXPECT_TRUE(chain_answers());
  system.stop();
  system.wait();
}

TEST_F(SystemFile, NamesTheThreadsOfItsComponents) {
  const System system = load_system(
      write("thread: all\ncomponents:\n  - {component: c}\n  - {component: c, thread: own}\n"));
  EXPECT_EQ(system.nodes.at(0).thread, "all");
  EXPECT_EQ(system.nodes.at(1).thread, "own");
}

TEST_F(SystemFile, RunsSeveralNodesOnOneThread) {
  RunningSystem system{load_system(write(std::string{"thread: one\n"} + kTwoDoublers))};
  EXPECT_TRUE(chain_answers());
  EXPECT_EQ(threads_named("one"), 1);
  system.stop();
  system.wait();
}

TEST_F(SystemFile, GivesThreadsRealTimePriorities) {
  const std::string nodes =
      "thread: all\ncomponents:\n  - {component: c}\n  - {component: d, thread: own}\n";
  const System system = load_system(write("real_time: {own: 48, all: 47, dds: 46}\n" + nodes));
  EXPECT_EQ(system.nodes.at(0).priority, 47);
  EXPECT_EQ(system.nodes.at(1).priority, 48);
  EXPECT_EQ(system.dds_priority, 46);
  EXPECT_EQ(load_system(write(nodes)).nodes.at(0).priority, 0);
  expect_complaint("real_time: {c: 48}\n" + nodes,
                   {path_ + ":1: `real_time.c`: no such thread; there are: all, dds, own"});
  expect_complaint("real_time: {own: 100}\n" + nodes, {path_ + ":1", "real_time.own", "99"});
  expect_complaint("real_time: {own: 0}\n" + nodes, {path_ + ":1", "real_time.own", "1"});
}

TEST_F(SystemFile, RunsThreadsWithTheirPriorities) {
  if (!test::may_use_real_time()) GTEST_SKIP() << "no right to real-time priorities";
  const std::string threads = "thread: one\nreal_time: {one: 3, dds: 2}\n";
  RunningSystem system{load_system(write(threads + kTwoDoublers))};
  EXPECT_TRUE(chain_answers());
  EXPECT_EQ(test::threads_with_priority(3), 1);
  system.stop();
  system.wait();
}

TEST_F(SystemFile, RunsOnlyWhatIsNamed) {
  const System system = load_system(write(kTwoDoublers));
  EXPECT_THROW(RunningSystem(system, {"third"}), std::invalid_argument);
  const RunningSystem running{system, {"second"}};
  EXPECT_TRUE(heard("b", 1));
  EXPECT_TRUE(heard("a", 0));
}

TEST_F(SystemFile, RunsAsOneProcessUntilSigterm) {
  ChildProcess program{"run_system", {"run", write(kTwoDoublers)}};
  EXPECT_TRUE(chain_answers());
  program.send(SIGTERM);
  EXPECT_EQ(program.wait(2.0), 0);
}

TEST_F(SystemFile, RunsAsSeparateProcessesAndEndsThemAll) {
  ChildProcess program{"run_system", {"run", write(kTwoDoublers), "--separate"}};
  EXPECT_TRUE(chain_answers());
  const auto children = children_of(program.pid());
  EXPECT_EQ(children.size(), 2U);
  program.send(SIGTERM);
  EXPECT_EQ(program.wait(5.0), 0);
  for (const pid_t child : children) EXPECT_TRUE(gone(child));
}

// Each process would find it again.
TEST_F(SystemFile, WithARetiredNameIsRefusedOnceBeforeAnyProcessStarts) {
  const std::string parameters = path_ + ".parameters";
  std::ofstream{parameters} << "/**:\n  ros__parameters:\n    command_timeout: 0.6\n";
  const std::string error = refusal_of("parameter_files: [" + parameters +
                                       "]\ncomponents:\n  - {component: safety_filter}\n"
                                       "  - {component: local_planner}\n");
  EXPECT_NE(error.find(parameters + ":3"), std::string::npos) << error;
  EXPECT_NE(error.find("base_timeout"), std::string::npos) << error;
}

TEST_F(SystemFile, WithAnUnknownParameterIsRefusedOnceAlsoForAComponentOfAThirdParty) {
  const std::string error =
      refusal_of("components:\n  - {component: test_component, parameters: {factr: 3.0}}\n");
  EXPECT_EQ(error, path_ +
                       ":2: node /test_component: factr = 3.0 is not a parameter of this node; "
                       "did you mean `factor`?");
}

TEST_F(SystemFile, SurvivesTheDeathOfOneProcess) {
  ChildProcess program{"run_system", {"run", write(kTwoDoublers), "--separate"}};
  ASSERT_TRUE(chain_answers());
  const auto children = children_of(program.pid());
  kill(children.at(0), SIGKILL);
  EXPECT_TRUE(spin_until([&] { return children_of(program.pid()).size() == 1; }, kTimeout, node_));
  EXPECT_TRUE(heard("b", 1));
  program.send(SIGINT);
  EXPECT_EQ(program.wait(5.0), 1);  // the exit status reports the killed process
}

TEST_F(SystemFile, RestartsComponentsMarkedRespawn) {
  std::string yaml = kTwoDoublers;
  yaml.replace(yaml.find("name: first"), 11, "name: first, respawn: true");
  ChildProcess program{"run_system", {"run", write(yaml), "--separate"}};
  ASSERT_TRUE(chain_answers());
  const auto before = children_of(program.pid());
  kill(before.at(0), SIGKILL);
  ASSERT_TRUE(spin_until(
      [&] {
        const auto now = children_of(program.pid());
        return now.size() == 2 && std::find(now.begin(), now.end(), before[0]) == now.end();
      },
      kTimeout, node_));
  EXPECT_TRUE(chain_answers());
  program.send(SIGINT);
  EXPECT_EQ(program.wait(5.0), 1);
}

TEST_F(SystemFile, DoesNotStartAgainWhatAWrongParameterEnded) {
  ChildProcess program{"run_system",
                       {"run",
                        write("components:\n  - {component: map_server, name: first, respawn: "
                              "true, parameters: {map: nowhere.bt}}\n"),
                        "--separate"}};
  EXPECT_EQ(program.wait(10.0), 1);
}

TEST(Respawn, WaitsLongerAfterEachEarlyExitAndResetsAfterAHealthyRun) {
  EXPECT_EQ(respawn_delay(0.0, 10.0), 0.5);
  EXPECT_EQ(respawn_delay(0.5, 1.0), 1.0);
  EXPECT_EQ(respawn_delay(16.0, 1.0), 30.0);
  EXPECT_EQ(respawn_delay(30.0, 1.0), 30.0);
  EXPECT_EQ(respawn_delay(30.0, 61.0), 0.5);
}

TEST_F(SystemFile, LeavesNoOrphanWhenKilled) {
  ChildProcess program{"run_system", {"run", write(kTwoDoublers), "--separate"}};
  ASSERT_TRUE(chain_answers());
  const auto children = children_of(program.pid());
  program.send(SIGKILL);
  EXPECT_EQ(program.wait(5.0), 128 + SIGKILL);
  for (const pid_t child : children) {
    const auto stat = "/proc/" + std::to_string(child) + "/stat";
    EXPECT_TRUE(spin_until(
        [&] {
          std::ifstream file{stat};
          std::string pid, name, state;
          return !(file >> pid >> name >> state) || state == "Z";
        },
        kTimeout, node_));
  }
}

TEST_F(SystemFile, WithAWrongParameterEndsWithStatusOne) {
  ChildProcess program{"run_system",
                       {"run", write(kTwoDoublers), "--ros-args", "-p", "first:factor:=99.0"}};
  EXPECT_EQ(program.wait(kTimeout), 1);
}

}  // namespace
}  // namespace tandem
