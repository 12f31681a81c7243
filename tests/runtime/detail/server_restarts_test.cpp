// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/server_restarts.hpp"

#include <gtest/gtest.h>

#include "runtime/datagram.hpp"
#include "tandem/runtime/detail/rtps_guard.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using rt::ServerRestarts;
using test::Datagram;
using test::Octets;

constexpr std::uint32_t kServersWriter = 0x000100c2, kServersReader = 0x000100c7;
const Octets kServer{0x44, 0x53, 3, 0x5f, 0x45, 0x50, 0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};
const Octets kRobot{9, 8, 7, 6, 5, 4, 3, 2, 1, 0, 1, 2};

constexpr std::uint32_t kStart = 1000, kRestart = 1001;  // [s]

class Restarts : public testing::TestWithParam<bool> {
 protected:
  // The announcement of a participant that was started at `time` [s], by `sender`.
  static Octets announcement(const Octets& sender, const Octets& announced, std::uint32_t time,
                             std::int64_t number = 1) {
    Octets time_body, guid = announced;
    test::append(time_body, time, GetParam());
    test::append(time_body, std::uint32_t{0}, GetParam());
    guid.insert(guid.end(), {0, 0, 1, 0xc1});
    return Datagram{GetParam()}
        .prefix(sender)
        .add(0x09, 0, time_body)
        .add_data({.reader = kServersReader,
                   .writer = kServersWriter,
                   .number = number,
                   .inline_qos = {{0x70, guid}}},
                  Datagram::list_payload({{0x15, Octets{2, 3, 0, 0}}, {0x50, guid}}, GetParam()))
        .octets();
  }
  static Octets heartbeat(std::uint32_t writer = kServersWriter) {
    return Datagram{GetParam()}
        .prefix(kServer)
        .add_heartbeat(1, 4, 10, kServersReader, writer)
        .octets();
  }
  bool restarts(Octets datagram) { return restarts_.are_shown_by(datagram, port_, now_); }
  bool is_removed(const Octets& datagram) {
    Octets octets = datagram;
    EXPECT_FALSE(restarts_.are_shown_by(octets, port_, now_));
    return octets != datagram;
  }

  ServerRestarts restarts_;
  std::uint64_t port_ = 1;  // from which the server sends
  double now_ = 1.0;
};
INSTANTIATE_TEST_SUITE_P(Orders, Restarts, testing::Bool());

TEST_P(Restarts, AreSeenByALaterTimeUnderTheSameNumber) {
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));  // repeated every 3 s
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kRestart)));
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kRestart)));  // reported before
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));    // delayed
  now_ += ServerRestarts::kLeastLife;
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kRestart + 1)));
}

// Forged announcements must not keep Fast DDS busy, nor hide the server's own.
TEST_P(Restarts, AreRare) {
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  int seen = 0;
  for (std::uint32_t i = 0; i < 1000; ++i, now_ += 0.01)
    if (restarts(announcement(kServer, kServer, kRestart + i))) ++seen;
  EXPECT_GE(seen, 9);
  EXPECT_LE(seen, 11);
  now_ += ServerRestarts::kLeastLife;
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kRestart + 1000)));
}

TEST_P(Restarts, AreNotSeenInChangesAndInWhatAServerSaysOfOthers) {
  EXPECT_FALSE(restarts(announcement(kServer, kRobot, kStart, 2)));
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  EXPECT_FALSE(restarts(announcement(kServer, kRobot, kRestart)));
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kRestart, 7)));  // another address
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kRestart, 7)));
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kRestart + 1)));
}

TEST(DiscoveryServers, AreKnownByTheirPrefix) {
  EXPECT_TRUE(rt::is_server(rt::prefix_at(kServer.data())));
  EXPECT_FALSE(rt::is_server(rt::prefix_at(kRobot.data())));
}

// What is acknowledged before the goodbye would never come again.
TEST_P(Restarts, AreSuspectedWhenTheServerSendsFromAnotherPort) {
  constexpr std::uint32_t kPublicationsWriter = 0x000003c2, kLivelinessWriter = 0x000200c2;
  const Octets of_robot = announcement(kServer, kRobot, kRestart, 5);
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  EXPECT_FALSE(is_removed(heartbeat()));
  EXPECT_FALSE(is_removed(of_robot));
  port_ = 2;
  EXPECT_TRUE(is_removed(heartbeat()));
  EXPECT_TRUE(is_removed(of_robot));
  EXPECT_TRUE(is_removed(heartbeat(kPublicationsWriter)));
  EXPECT_FALSE(is_removed(heartbeat(kLivelinessWriter)));
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kRestart)));
  EXPECT_FALSE(is_removed(of_robot));
  EXPECT_FALSE(is_removed(heartbeat()));
}

TEST_P(Restarts, AreSuspectedBeforeTheServerHasAnnouncedItself) {
  EXPECT_FALSE(is_removed(heartbeat()));
  port_ = 2;
  EXPECT_TRUE(is_removed(heartbeat()));
  // The old one's heartbeat may have told Fast DDS not to wait for what the new one announces.
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kStart)));
  EXPECT_FALSE(is_removed(heartbeat()));
}

TEST_P(Restarts, AreShownOnceByAForgedHeartbeatThatCameFirst) {
  EXPECT_FALSE(is_removed(heartbeat()));
  port_ = 2;
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kStart)));
  for (port_ = 1; port_ < 20; ++port_, now_ += ServerRestarts::kLeastLife) {
    (void)is_removed(heartbeat());
    EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  }
}

TEST_P(Restarts, AreRareAlsoAfterAForgedHeartbeat) {
  EXPECT_FALSE(is_removed(heartbeat()));
  port_ = 2;
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kStart)));
  now_ += 0.9 * ServerRestarts::kLeastLife;
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kRestart)));
  now_ += 0.2 * ServerRestarts::kLeastLife;
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kRestart)));
}

TEST_P(Restarts, AreNoLongerSuspectedAfterTheSameAnnouncement) {
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  port_ = 2;
  EXPECT_TRUE(is_removed(heartbeat()));
  EXPECT_FALSE(is_removed(announcement(kServer, kServer, kStart)));
  EXPECT_FALSE(is_removed(heartbeat()));
  port_ = 1;
  EXPECT_FALSE(is_removed(heartbeat())) << "it has two addresses";
}

TEST_P(Restarts, AreNotSuspectedOfTheServerItselfWhileOthersForgeItsDatagrams) {
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  for (std::uint32_t forged = 2; forged < 100; ++forged, now_ += 0.1) {
    port_ = forged;
    EXPECT_TRUE(is_removed(heartbeat()));
    (void)restarts(announcement(kServer, kServer, kStart + forged % 2 * forged));
    port_ = 1;
    EXPECT_FALSE(is_removed(heartbeat()));
    EXPECT_FALSE(is_removed(announcement(kServer, kServer, kStart)));
  }
}

// Its announcement of itself has a higher number than the old one's if it has linked other servers.
TEST_P(Restarts, AreSeenByAnotherTimeUnderSuspicion) {
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  port_ = 2;
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kRestart, 3)));
}

// As of a host whose clock is set later than the server is started.
TEST_P(Restarts, AreSeenByAnEarlierTimeUnderSuspicion) {
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kRestart)));
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));  // delayed
  port_ = 2;
  EXPECT_TRUE(restarts(announcement(kServer, kServer, kStart)));
  EXPECT_FALSE(is_removed(heartbeat()));
}

TEST_P(Restarts, AreNotSeenInALateAnnouncementOfTheOldServer) {
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  port_ = 2;
  ASSERT_TRUE(restarts(announcement(kServer, kServer, kRestart)));
  now_ += 2.0 * ServerRestarts::kLeastLife;
  port_ = 1;
  EXPECT_FALSE(restarts(announcement(kServer, kServer, kStart)));
}

// Also if it sends from two other ports in turn.
TEST_P(Restarts, AreSuspectedForALimitedTime) {
  EXPECT_FALSE(is_removed(heartbeat()));
  const double begin = now_;
  for (port_ = 2; now_ < begin + 0.95 * ServerRestarts::kLongestSuspicion; port_ = 5 - port_) {
    EXPECT_TRUE(is_removed(heartbeat()));
    now_ += 0.1 * ServerRestarts::kLongestSuspicion;
  }
  now_ += 0.1 * ServerRestarts::kLongestSuspicion;
  EXPECT_FALSE(is_removed(heartbeat()));
}

TEST_P(Restarts, AreSuspectedLongAfterAStrayDatagram) {
  EXPECT_FALSE(is_removed(heartbeat()));
  port_ = 2;
  EXPECT_TRUE(is_removed(heartbeat()));
  now_ += 3.0 * ServerRestarts::kLongestSuspicion;
  port_ = 3;
  EXPECT_TRUE(is_removed(heartbeat()));
}

TEST(DiscoveryServers, LeaveWithAValidGoodbye) {
  const Octets goodbye = rt::goodbye_of(rt::prefix_at(kServer.data()), 0x100000002);
  EXPECT_EQ(rt::check_datagram(goodbye, {}), rt::Drop::kNone);
  Octets without_heartbeat = goodbye;
  without_heartbeat.erase(without_heartbeat.begin() + 20, without_heartbeat.begin() + 52);
  EXPECT_EQ(rt::check_datagram(without_heartbeat, {.all_protected = true}), rt::Drop::kGoodbye);
  EXPECT_TRUE(std::equal(kServer.begin(), kServer.end(), goodbye.begin() + 8));
  rt::rtps_message::Submessage heartbeat{}, data{};
  rt::rtps_message::Submessages all{goodbye};
  ASSERT_TRUE(all.next(heartbeat));
  ASSERT_TRUE(all.next(data));
  EXPECT_TRUE(all.at_end());
  EXPECT_EQ(heartbeat.sequence_number(8), 0x100000002);
  EXPECT_EQ(data.entity(4), kServersReader);
  EXPECT_EQ(data.entity(8), kServersWriter);
  EXPECT_EQ(data.sequence_number(12), 0x100000002);
}

TEST_P(Restarts, AreNotSeenInWhatIsTooShort) {
  constexpr std::size_t kData = 32;  // after the header and the time
  ASSERT_FALSE(restarts(announcement(kServer, kServer, kStart)));
  const Octets again = announcement(kServer, kServer, kRestart);
  const std::size_t guid_end = again.size() - 8;  // before the entity id and the sentinel
  for (std::size_t size = kData + 4; size < guid_end; ++size) {
    Octets part{again.begin(), again.begin() + static_cast<std::ptrdiff_t>(size)};
    part[kData + 2] = part[kData + 3] = 0;  // the submessage ends with the datagram
    EXPECT_FALSE(restarts(part)) << size;
  }
  EXPECT_TRUE(restarts(again));
}

}  // namespace
}  // namespace tandem
