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

class Restarts : public testing::TestWithParam<bool> {
 protected:
  void acknowledge(const Octets& participant, std::int64_t base,
                   std::uint32_t writer = kServersWriter) {
    restarts_.sent(std::move(Datagram{GetParam()}
                                 .add_destination(participant)
                                 .add_acknack(base, 0, -1, kServersReader, writer))
                       .octets());
  }
  Octets after_heartbeat(const Octets& participant, std::int64_t last,
                         std::uint32_t writer = kServersWriter) {
    const auto heartbeat =
        std::move(Datagram{GetParam()}.prefix(participant).add_heartbeat(1, last, 1, 0, writer));
    return restarts_.goodbye_before(heartbeat.octets());
  }

  ServerRestarts restarts_;
};
INSTANTIATE_TEST_SUITE_P(Orders, Restarts, testing::Bool());

TEST_P(Restarts, AreSeenByNumbersThatHaveFallen) {
  acknowledge(kServer, 12);
  EXPECT_TRUE(after_heartbeat(kServer, 11).empty());  // nothing new
  EXPECT_TRUE(after_heartbeat(kServer, 15).empty());
  EXPECT_FALSE(after_heartbeat(kServer, 10).empty());
  EXPECT_TRUE(after_heartbeat(kServer, 10).empty());  // reported before
  acknowledge(kServer, 11);
  EXPECT_FALSE(after_heartbeat(kServer, 4).empty());
}

TEST_P(Restarts, AreThoseOfServersThatThisParticipantHasHeard) {
  EXPECT_TRUE(after_heartbeat(kServer, 1).empty());
  acknowledge(kServer, 12, 0x000003c2);  // endpoints
  EXPECT_TRUE(after_heartbeat(kServer, 1).empty());
  acknowledge(kRobot, 12);
  EXPECT_TRUE(after_heartbeat(kRobot, 1).empty());
  acknowledge(kServer, 12);
  EXPECT_TRUE(after_heartbeat(kServer, 1, 0x000003c2).empty());
  EXPECT_TRUE(after_heartbeat(kRobot, 1).empty());
}

TEST_P(Restarts, AreFollowedByAValidGoodbyeUnderTheNextNumber) {
  acknowledge(kServer, 0x100000002);
  const Octets goodbye = after_heartbeat(kServer, 1);
  EXPECT_EQ(rt::check_datagram(goodbye, {}), rt::Drop::kNone);
  EXPECT_EQ(rt::check_datagram(goodbye, {.all_protected = true}), rt::Drop::kGoodbye);
  EXPECT_TRUE(std::equal(kServer.begin(), kServer.end(), goodbye.begin() + 8));
  rt::rtps_message::Submessage data;
  rt::rtps_message::Submessages all{goodbye};
  ASSERT_TRUE(all.next(data));
  EXPECT_TRUE(all.at_end());
  EXPECT_EQ(data.entity(4), kServersReader);
  EXPECT_EQ(data.entity(8), kServersWriter);
  EXPECT_EQ(data.sequence_number(12), 0x100000002);
}

TEST_P(Restarts, AreNotSeenInWhatIsTooShort) {
  acknowledge(kServer, 12);
  const Octets heartbeat =
      Datagram{GetParam()}.prefix(kServer).add_heartbeat(1, 1, 1, 0, kServersWriter).octets();
  for (std::size_t size = 0; size < heartbeat.size(); ++size) {
    const std::span part{heartbeat.data(), size};
    restarts_.sent(part);
    EXPECT_TRUE(restarts_.goodbye_before(part).empty()) << size;
  }
}

}  // namespace
}  // namespace tandem
