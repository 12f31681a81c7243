// SPDX-License-Identifier: Apache-2.0
// What a standing robot loads and sends. Fast DDS repeats HEARTBEATs of a writer for good when a
// reader does not answer, which looks like nothing in a log and takes half of a small computer.
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "support/child_process.hpp"
#include "support/paths.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/domain_view.hpp"

namespace tandem::test {
namespace {

constexpr std::size_t kNodes = 10;      // of a robot
constexpr double kWindow = 2.0;         // [s]
constexpr double kFewPerSecond = 20.0;  // five robots with such HEARTBEATs sent 346

// UDP datagrams that this thread's network namespace has received.
long datagrams() {
  std::ifstream file{"/proc/thread-self/net/snmp"};
  const auto is_udp = [](const std::string& line) { return line.starts_with("Udp: "); };
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words{line};
    if (is_udp(line)) rows.push_back({std::istream_iterator<std::string>{words}, {}});
  }
  const auto column = std::find(rows.at(0).begin(), rows.at(0).end(), "InDatagrams");
  return std::stol(rows.at(1).at(static_cast<std::size_t>(column - rows.at(0).begin())));
}

std::vector<std::string> robot(const std::string& ns) {
  std::vector<std::string> arguments{"run",
                                     source_path("bringup/systems/teleop.yaml"),
                                     "--ros-args",
                                     "-p",
                                     "dashboard:port:=0",
                                     "-r",
                                     "__ns:=" + ns};
  for (const std::string topic : {"tf", "tf_static", "clock", "diagnostics"})
    arguments.insert(arguments.end(), {"-r", "/" + topic + ":=" + topic});
  return arguments;
}

class AtRest : public testing::Test {
 protected:
  void SetUp() override {
    if (unshare(CLONE_NEWNET) != 0 || std::system("ip link set lo up") != 0)
      GTEST_SKIP() << "NOT TESTED: no network namespace here";
  }
};

// Waits until the observer knows all nodes of so many robots.
bool knows(rt::Node& observer, std::size_t robots) {
  const rt::DomainView view{observer};
  const auto knows_all = [&] {
    std::size_t nodes = 0;
    for (const auto& participant : view.look().participants)
      if (!participant.ours) nodes += participant.nodes.size();
    return nodes == robots * kNodes;
  };
  return spin_until(knows_all, kLongTimeout, observer);
}

TEST_F(AtRest, ARobotLoadsNoLibrariesOfOtherCommandsAndOfSticksThatAreNotThere) {
  const ChildProcess robot_process{"../tandem", robot("/a")};
  rt::Node observer{"observer"};
  ASSERT_TRUE(knows(observer, 1));
  std::ifstream file{"/proc/" + std::to_string(robot_process.pid()) + "/maps"};
  const std::string maps{std::istreambuf_iterator<char>{file}, {}};
  const auto loads = [&](const char* library) { return maps.find(library) != std::string::npos; };
  EXPECT_TRUE(loads("libtandem_joystick"));
  EXPECT_FALSE(loads("libtandem-commands"));
  EXPECT_FALSE(loads("libcairo"));
  std::error_code missing;
  const bool may_have_stick = !std::filesystem::is_empty("/sys/class/input", missing);
  EXPECT_FALSE(loads("libSDL2") && !may_have_stick);
}

TEST_F(AtRest, TwoRobotsAndAnObserverSendEachOtherAlmostNothing) {
  const ChildProcess first{"../tandem", robot("/a")}, second{"../tandem", robot("/b")};
  rt::Node observer{"observer"};
  ASSERT_TRUE(knows(observer, 2));
  ASSERT_GT(datagrams(), 100) << "those of discovery are not counted";
  double rate = 0.0, least = 1e9;
  const auto is_quiet = [&] {
    const long before = datagrams();
    const double begin = rt::steady_seconds();
    (void)spin_until([] { return false; }, kWindow, observer);
    rate = static_cast<double>(datagrams() - before) / (rt::steady_seconds() - begin);
    least = std::min(least, rate);
    return rate < kFewPerSecond;
  };
  EXPECT_TRUE(spin_until(is_quiet, kLongTimeout, observer)) << least << " datagrams a second";
}

}  // namespace
}  // namespace tandem::test
