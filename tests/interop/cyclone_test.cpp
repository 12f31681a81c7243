// SPDX-License-Identifier: Apache-2.0
// Tests with peers on Cyclone DDS: one publishes cmd_vel_user and reads odom and cmd_vel, another
// sets a parameter, a third has long been writing when a reader of ours joins.
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/child_process.hpp"
#include "support/nothing_dropped.hpp"
#include "support/paths.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

TEST(CyclonePeer, DrivesOurRobotAndReadsItsOdometry) {
  const test::NothingDropped nothing_dropped;
  // With policy manual the peer's Twist passes only the safety filter.
  test::ChildProcess robot{"../tandem",
                           {"run", test::source_path("bringup/systems/teleop.yaml"), "--ros-args",
                            "-p", "arbitration:policy:=manual"}};
  test::ChildProcess peer{"cyclone_peer", {std::getenv("ROS_DOMAIN_ID"), "0.3", "0.0", "60"}};
  EXPECT_EQ(peer.wait(70.0), 0);
  robot.send(SIGTERM);
  EXPECT_EQ(robot.wait(5.0), 0);
}

TEST(CyclonePeer, SetsAndGetsAParameterOfOurs) {
  const test::NothingDropped nothing_dropped;
  const auto teleop = rt::load_component("teleop", {.name = "teleop", .ns = "/robot"});
  const char* domain = std::getenv("ROS_DOMAIN_ID");
  const auto set = [&](const char* name, const char* value) {
    test::ChildProcess peer{"cyclone_param_peer", {domain, "/robot/teleop", name, value, "30"}};
    return peer.wait(40.0);
  };
  EXPECT_EQ(set("scale_linear", "0.25"), 0);
  EXPECT_EQ(set("scale_linear", "99"), 3);  // out of range
  EXPECT_EQ(set("joy_timeout", "4.0"), 3);  // read-only
  EXPECT_EQ(set("scale_linear", "0.5"), 0);
}

// More numbers than the guard lets one HEARTBEAT skip. TANDEM_FAR_AHEAD sets another count.
TEST(CyclonePeer, IsHeardByAReaderThatJoinsItFarAhead) {
  const test::NothingDropped nothing_dropped;
  const char* far_ahead = std::getenv("TANDEM_FAR_AHEAD");
  test::ChildProcess writer{
      "cyclone_far_peer",
      {std::getenv("ROS_DOMAIN_ID"), far_ahead == nullptr ? "5000000" : far_ahead, "20", "60"}};
  rt::Node node{"joins_later"};
  const auto pong =
      node.create_publisher(rt::Topic<geometry_msgs::msg::Twist>{"pong", rt::kLatched});
  ASSERT_TRUE(test::spin_until([&] { return pong.matched() == 1; }, 400.0, node));
  test::ChildProcess reader{"peer", {"echo"}};
  EXPECT_EQ(writer.wait(70.0), 0);
  reader.send(SIGTERM);
  EXPECT_EQ(reader.wait(5.0), 0);
}

TEST(CyclonePeer, IsHeardAgainByAReaderThatWasStopped) {
  constexpr double kOutage = 8.0;  // [s], less than the lease after which a reader is forgotten
  const test::NothingDropped nothing_dropped;
  test::ChildProcess writer{"cyclone_far_peer",
                            {std::getenv("ROS_DOMAIN_ID"), "0", "1000000", "60"}};
  test::ChildProcess reader{"peer", {"echo"}};
  rt::Node node{"counter"};
  int pongs = 0;
  const auto pong = node.create_subscription(
      rt::Topic<geometry_msgs::msg::Twist>{"pong", rt::kLatched}, [&](const auto&) { ++pongs; });
  const auto answers = [&] {
    const int wanted = pongs + 20;
    return test::spin_until([&] { return pongs >= wanted; }, 20.0, node);
  };
  ASSERT_TRUE(answers());
  reader.send(SIGSTOP);
  (void)test::spin_until([] { return false; }, kOutage, node);
  reader.send(SIGCONT);
  EXPECT_TRUE(answers());
  reader.send(SIGTERM);
  EXPECT_EQ(reader.wait(5.0), 0);
  writer.send(SIGTERM);
}

}  // namespace
}  // namespace tandem
