// SPDX-License-Identifier: Apache-2.0
// Datagrams that end a process which parses them: the robot drives on, and can be stopped.
#include <csignal>

#include "runtime/datagram.hpp"
#include "support/udp_sender.hpp"
#include "system/system_under_test.hpp"

namespace tandem::test {
namespace {

constexpr int kParticipants = 16;  // of the system and the watcher, with some to spare

TEST(HostileWire, EndsNoProcessAndTheRobotDrivesAndStops) {
  SystemUnderTest system;
  system.start_all();
  ASSERT_TRUE(system.wait_until_driving());
  const UdpSender stranger;
  const auto files = datagram_files("hostile");
  ASSERT_FALSE(files.empty());
  for (const auto& file : files) {
    for (int i = 0; i < 3; ++i) stranger.send_to_all(read(file), kParticipants);
    const long heard = system.commands;
    ASSERT_TRUE(system.wait_until([&] { return system.commands > heard + 2; }, 5.0)) << file;
  }
  ASSERT_TRUE(system.wait_until_driving());
  const auto button = system.node().create_publisher(topics::e_stop);
  std_msgs::msg::Bool pressed;
  pressed.data(true);
  button.publish(pressed);
  EXPECT_TRUE(system.wait_until([&] { return system.stands(); }, 10.0));
  EXPECT_EQ(system.collisions, 0u);
  for (const char* name : kComponents) system.process(name).send(SIGTERM);
  for (const char* name : kComponents) EXPECT_EQ(system.process(name).wait(5.0), 0) << name;
}

}  // namespace
}  // namespace tandem::test
