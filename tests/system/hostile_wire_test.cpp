// SPDX-License-Identifier: Apache-2.0
// Sends datagrams that crash a vulnerable parser: the robot must drive on and remain stoppable.
#include <csignal>

#include "system/wire_attacks.hpp"

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

// The long versions: wire_attacks.
TEST(HostileWire, MutatedDatagramsOfTheSessionEndNoProcessAndFillNoMemory) {
  const LoopbackTap tap;
  if (!tap.works()) GTEST_SKIP() << "no CAP_NET_RAW";
  AttackedSystem attacked;
  ASSERT_TRUE(attacked.system().wait_until_driving());
  const auto session = tap.listen(2.0, 4000);
  ASSERT_GT(session.size(), 200u);
  attacked.note_memory();
  EXPECT_GT(attacked.send_mutated(20'000, session, 1), 10'000);
  EXPECT_TRUE(attacked.all_alive());
  EXPECT_LT(attacked.growth(), most_memory(20.0));
  EXPECT_TRUE(attacked.system().wait_until_driving());
  EXPECT_TRUE(attacked.stops());
}

TEST(HostileWire, ForgedAnnouncementsFillNoMemoryAndARealProcessJoins) {
  AttackedSystem attacked;
  ASSERT_TRUE(attacked.system().wait_until_driving());
  attacked.note_memory();
  attacked.announce(20'000);
  const double start = rt::steady_seconds();
  ChildProcess newcomer{"peer", {"join"}};
  std::optional<int> joined;
  for (int i = 0; i < 50 && !joined; ++i) {
    attacked.announce(500);
    joined = newcomer.wait(0.01);
  }
  if (!joined) joined = newcomer.wait(5.0);
  EXPECT_EQ(joined, 0);
  EXPECT_LT(rt::steady_seconds() - start, 5.0);
  EXPECT_TRUE(attacked.all_alive());
  EXPECT_LT(attacked.growth(), most_memory(50.0));
  EXPECT_TRUE(attacked.system().wait_until_driving());
  EXPECT_TRUE(attacked.stops());
}

}  // namespace
}  // namespace tandem::test
