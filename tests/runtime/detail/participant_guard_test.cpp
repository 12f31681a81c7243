// SPDX-License-Identifier: Apache-2.0
// Tests a guard in front of each of two participants of a process.
#include "tandem/runtime/detail/participant_guard.hpp"

#include <gtest/gtest.h>

#include "runtime/datagram.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using rt::ParticipantGuard;
using test::Datagram;
using test::Octets;

class TwoGuards : public testing::Test {
 protected:
  // Builtin endpoints have the same entity ids in all participants.
  static constexpr std::uint32_t kAnnouncer = 0x000100c2, kDetector = 0x000100c7;
  static constexpr std::uint32_t kLoopback = 0x0100007f;
  const Octets server_{0x44, 0x53, 0, 0x5f, 0x45, 0x50, 0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};

  void acknowledge(ParticipantGuard& guard, std::int64_t first_missing) {
    guard.sent(std::move(Datagram{}.add_destination(server_).add_acknack(first_missing, 0, -1,
                                                                         kDetector, kAnnouncer))
                   .octets(),
               1.0);
  }
  // The submessage that is left of a GAP from `first` to before `end`.
  rt::rtps_message::Submessage passed(ParticipantGuard& guard, std::int64_t first,
                                      std::int64_t end) {
    datagram_ = std::move(Datagram{}.prefix(server_).add_gap(first, end, 0, kDetector, kAnnouncer))
                    .octets();
    EXPECT_TRUE(guard.admits(datagram_, kLoopback, 1.0));
    rt::rtps_message::Submessage submessage{};
    EXPECT_TRUE(rt::rtps_message::Submessages{datagram_}.next(submessage));
    return submessage;
  }

  rt::WireGuard process_{{}};
  ParticipantGuard first_{process_, true}, second_{process_, true};
  Octets datagram_;
};

// A wide GAP becomes a HEARTBEAT for a reader that has all before it. To one that misses something,
// that HEARTBEAT would say that it is lost: a robot's second participant had the announcement of a
// discovery server, its first never got it, and the robot stayed unknown.
TEST_F(TwoGuards, WhatOneParticipantHasTheOtherMayMiss) {
  acknowledge(first_, 1);
  acknowledge(second_, 2);
  constexpr std::int64_t kWide = 2 * rt::ReaderProgress::kWide;
  EXPECT_EQ(passed(second_, 2, 2 + kWide).id, rt::rtps_message::kHeartbeat);
  const auto gap = passed(first_, 2, 2 + kWide);
  EXPECT_EQ(gap.id, rt::rtps_message::kGap);
  EXPECT_EQ(gap.sequence_number(8), 2);
}

TEST_F(TwoGuards, CountDropsForTheirProcess) {
  datagram_ = Octets(8, 1);
  EXPECT_FALSE(first_.admits(datagram_, kLoopback, 1.0));
  EXPECT_FALSE(second_.admits(datagram_, kLoopback, 1.0));
  EXPECT_EQ(process_.received(), 2u);
  ASSERT_EQ(process_.drops().size(), 1u);
  EXPECT_EQ(process_.drops()[0].count, 2u);
}

}  // namespace
}  // namespace tandem
