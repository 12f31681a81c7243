// SPDX-License-Identifier: Apache-2.0
// Tests that two Tandem processes discover each other through a Fast DDS discovery server alone.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "support/child_process.hpp"
#include "support/nothing_dropped.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/node.hpp"

namespace tandem {
namespace {

constexpr const char* kServer = "/usr/bin/fast-discovery-server";
constexpr double kTimeout = 30.0;  // [s]

// The node receives odometry of `robot` although neither uses multicast discovery.
TEST(DiscoveryServer, BringsOurProcessesTogether) {
  if (!std::filesystem::exists(kServer)) GTEST_SKIP() << kServer << " is not installed";
  const test::NothingDropped nothing_dropped;
  const std::string port = std::to_string(20'000 + getpid() % 10'000);
  test::ChildProcess server{std::filesystem::relative(kServer, test::ChildProcess::folder()),
                            {"-i", "0", "-l", "127.0.0.1", "-p", port}};
  setenv("ROS_DISCOVERY_SERVER", ("127.0.0.1:" + port).c_str(), 1);
  test::ChildProcess robot{
      "../tandem",
      {"run", test::source_path("bringup/systems/teleop.yaml"), "--only", "diff_drive_sim"}};
  rt::Node node{"tester"};
  int heard = 0;
  const auto odom = node.create_subscription(rt::Topic<nav_msgs::msg::Odometry>{"/odom"},
                                             [&](const auto&) { ++heard; });
  EXPECT_TRUE(test::spin_until([&] { return heard > 3; }, kTimeout, node));
  server.send(SIGKILL);  // participants that are already matched no longer need it
  (void)server.wait(5.0);
  heard = 0;
  EXPECT_TRUE(test::spin_until([&] { return heard > 3; }, kTimeout, node));
  unsetenv("ROS_DISCOVERY_SERVER");
}

// A program that comes later meets a robot that the server knew before it died, although the server
// is back long before the robot's lease of the old one (20 s) has ended.
TEST(DiscoveryServer, BringsThemTogetherAfterItHasBeenRestarted) {
  if (!std::filesystem::exists(kServer)) GTEST_SKIP() << kServer << " is not installed";
  const std::string port = std::to_string(20'000 + (getpid() + 2) % 10'000);
  const std::string program = std::filesystem::relative(kServer, test::ChildProcess::folder());
  const std::vector<std::string> arguments{"-i", "0", "-l", "127.0.0.1", "-p", port};
  auto server = std::make_unique<test::ChildProcess>(program, arguments);
  setenv("ROS_DISCOVERY_SERVER", ("127.0.0.1:" + port).c_str(), 1);
  test::ChildProcess robot{
      "../tandem",
      {"run", test::source_path("bringup/systems/teleop.yaml"), "--only", "diff_drive_sim"}};
  const auto hears_the_robot = [](double max_wait) {
    rt::Node node{"tester"};
    int heard = 0;
    const auto odom = node.create_subscription(rt::Topic<nav_msgs::msg::Odometry>{"/odom"},
                                               [&](const auto&) { ++heard; });
    return test::spin_until([&] { return heard > 3; }, max_wait, node);
  };
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(hears_the_robot(kTimeout));
  server->send(SIGKILL);
  (void)server->wait(5.0);
  server = std::make_unique<test::ChildProcess>(program, arguments);
  EXPECT_TRUE(hears_the_robot(12.0)) << "before the lease ends";
  unsetenv("ROS_DISCOVERY_SERVER");
}

// A server tells its clients only of what they need; `record` needs to know everything.
TEST(DiscoveryServer, HidesNothingFromRecord) {
  if (!std::filesystem::exists(kServer)) GTEST_SKIP() << kServer << " is not installed";
  const std::string port = std::to_string(20'000 + (getpid() + 1) % 10'000);
  test::ChildProcess server{std::filesystem::relative(kServer, test::ChildProcess::folder()),
                            {"-i", "0", "-l", "127.0.0.1", "-p", port}};
  setenv("ROS_DISCOVERY_SERVER", ("127.0.0.1:" + port).c_str(), 1);
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("tandem_super_client_" + std::to_string(getpid()));
  test::ChildProcess robot{
      "../tandem",
      {"run", test::source_path("bringup/systems/teleop.yaml"), "--only", "diff_drive_sim"}};
  test::ChildProcess recorder{"../tandem", {"record", "-o", folder.string(), "/odom"}};
  const auto recorded = [&] {
    std::error_code missing;
    std::uintmax_t size = 0;
    for (const auto& file : std::filesystem::directory_iterator{folder, missing})
      size += file.file_size(missing);
    return size > 20'000;
  };
  rt::Node node{"tester"};
  EXPECT_TRUE(test::spin_until(recorded, kTimeout, node));
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(kTimeout), 0);
  std::filesystem::remove_all(folder);
  unsetenv("ROS_DISCOVERY_SERVER");
}

// Counter-check of the first test: without the server the node receives nothing.
TEST(DiscoveryServer, IsRequiredByAProcessThatNamesIt) {
  setenv("ROS_DISCOVERY_SERVER", "127.0.0.1:19999", 1);
  test::ChildProcess robot{
      "../tandem",
      {"run", test::source_path("bringup/systems/teleop.yaml"), "--only", "diff_drive_sim"}};
  rt::Node node{"tester"};
  int heard = 0;
  const auto odom = node.create_subscription(rt::Topic<nav_msgs::msg::Odometry>{"/odom"},
                                             [&](const auto&) { ++heard; });
  EXPECT_FALSE(test::spin_until([&] { return heard > 0; }, 3.0, node));
  unsetenv("ROS_DISCOVERY_SERVER");
}

}  // namespace
}  // namespace tandem
