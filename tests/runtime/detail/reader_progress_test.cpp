// SPDX-License-Identifier: Apache-2.0
// Tests well-formed numbers that would move a reader where its writer never was, or make Fast DDS
// keep or count too much.
#include "tandem/runtime/detail/reader_progress.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "runtime/datagram.hpp"
#include "tandem/runtime/detail/rtps_guard.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using rt::ReaderProgress;
using rt::WriterReach;
using test::Datagram;
using test::Octets;

const Octets kPeer{9, 8, 7, 6, 5, 4, 3, 2, 1, 0, 1, 2};
constexpr std::uint32_t kReader = 0x00001204;
constexpr double kHour = 3600.0;  // [s]

rt::rtps_message::Submessage first_of(const Octets& octets) {
  rt::rtps_message::Submessage submessage{};
  EXPECT_TRUE(rt::rtps_message::Submessages{octets}.next(submessage));
  return submessage;
}

// --- what a writer can have reached ---

TEST(Reach, BelievesTheFirstClaimAndSmallSteps) {
  WriterReach reach;
  EXPECT_TRUE(reach.believes(100'000'000, 1.0));
  EXPECT_TRUE(reach.believes(100'000'000 + WriterReach::kLeap, 1.0));
  EXPECT_TRUE(reach.believes(1, 1.0));
  EXPECT_EQ(reach.top(), 100'000'000 + WriterReach::kLeap);
}

TEST(Reach, BelievesALeapThatIsClaimedRepeatedly) {
  WriterReach reach;
  ASSERT_TRUE(reach.believes(100, 0.0));
  EXPECT_FALSE(reach.believes(800, 8.00));
  EXPECT_FALSE(reach.believes(803, 8.03));
  EXPECT_FALSE(reach.believes(806, 8.06));
  EXPECT_FALSE(reach.believes(809, 8.09)) << "too short a time";
  EXPECT_TRUE(reach.believes(812, 8.12));
  EXPECT_EQ(reach.top(), 812);
}

TEST(Reach, BelievesNoLeapThatTheWritersNextMessageContradicts) {
  WriterReach reach;
  std::int64_t number = 100;
  for (double now = 0.0; now < 60.0; now += 0.01) {
    ASSERT_TRUE(reach.believes(++number, now));
    ASSERT_FALSE(reach.believes(900 + number, now + 0.003));
    ASSERT_FALSE(reach.believes(901 + number, now + 0.006));
  }
}

TEST(Reach, BelievesNoLeapFasterThanAWriterCounts) {
  WriterReach reach;
  ASSERT_TRUE(reach.believes(100, 0.0));
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(reach.believes(1'000'000'000, 0.1 * i));
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(reach.believes(1'000'000'000, 3 * kHour + i));
  EXPECT_TRUE(reach.believes(1'000'000'000, 3 * kHour + 2));
}

TEST(Reach, BelievesNoNumberThatNoWriterReaches) {
  EXPECT_FALSE(WriterReach{}.believes(WriterReach::kEnd, 0.0));
  EXPECT_FALSE(WriterReach{}.believes(std::numeric_limits<std::int64_t>::max(), 0.0));
}

// --- datagrams, in either byte order ---

class Progress : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static Datagram from_peer() {
    return std::move(Datagram{GetParam()}.prefix(kPeer));
  }
  [[nodiscard]] static Datagram sample(std::int64_t number, std::uint32_t reader = 0) {
    return std::move(from_peer().add_data({.reader = reader, .number = number}, Octets(8, 1)));
  }
  [[nodiscard]] static Datagram heartbeat(std::int64_t first, std::int64_t last,
                                          std::uint32_t count = 1) {
    return std::move(from_peer().add_heartbeat(first, last, count));
  }
  void acknowledge(std::int64_t base, std::uint32_t reader = kReader) {
    const auto acknack =
        std::move(Datagram{GetParam()}.add_destination(kPeer).add_acknack(base, 0, -1, reader));
    progress_.sent(acknack.octets(), now_);
  }
  // What becomes of it.
  Octets narrowed(const Datagram& datagram) {
    Octets octets = datagram.octets();
    taken_ = progress_.narrow(octets, now_);
    EXPECT_EQ(rt::check_datagram(octets, {}), rt::Drop::kNone);
    return octets;
  }
  bool passes(const Datagram& datagram) {
    return narrowed(datagram) == datagram.octets() && taken_ == 0;
  }
  bool is_removed(const Datagram& datagram) {
    (void)narrowed(datagram);
    return taken_ == 1;
  }

  ReaderProgress progress_;
  double now_ = kHour;
  int taken_ = 0;
};
INSTANTIATE_TEST_SUITE_P(Orders, Progress, testing::Bool());

TEST_P(Progress, LeavesUsualTrafficUnchanged) {
  acknowledge(5);
  EXPECT_TRUE(passes(sample(5)));
  EXPECT_TRUE(passes(from_peer().add_gap(6, 30, 32)));
  EXPECT_TRUE(passes(heartbeat(5, 40, 7)));
  EXPECT_TRUE(passes(sample(20)));
}

// A server has announced others' endpoints to others in between.
TEST_P(Progress, TheNumbersOfADiscoveryServerLeap) {
  constexpr std::uint32_t kUsersWriter = 0x00001203, kPublicationsWriter = 0x000003c2;
  const Octets server{0x44, 0x53, 1, 0x5f, 0x45, 0x50, 0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};
  const auto sample = [&](const Octets& prefix, std::uint32_t writer, std::int64_t number) {
    const Octets payload = Datagram::list_payload({{0x5a, Octets(16, 1)}}, GetParam());
    return std::move(
        from_peer().prefix(prefix).add_data({.writer = writer, .number = number}, payload));
  };
  for (const Octets& prefix : {server, Octets(kPeer)})
    for (const std::uint32_t writer : {kUsersWriter, kPublicationsWriter}) {
      const bool leaps = prefix == server && writer == kPublicationsWriter;
      ASSERT_TRUE(passes(sample(prefix, writer, 256)));
      constexpr std::int64_t kFar = 307 + ReaderProgress::kServerWindow;
      EXPECT_EQ(passes(sample(prefix, writer, 307)), leaps);
      EXPECT_EQ(passes(sample(prefix, writer, kFar)), leaps);
      EXPECT_FALSE(passes(sample(prefix, writer, kFar + 1 + ReaderProgress::kServerWindow)));
    }
}

// With a hundred robots, most of what a server has announced was for others. A client that has the
// beginning must not lose what is for it.
TEST_P(Progress, AClientOfADiscoveryServerTakesWhatIsFarAheadOfWhatItMisses) {
  constexpr std::uint32_t kPublicationsWriter = 0x000003c2, kPublicationsReader = 0x000003c7;
  const Octets server{0x44, 0x53, 0, 0x5f, 0x45, 0x50, 0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};
  const Octets payload = Datagram::list_payload({{0x5a, Octets(16, 1)}}, GetParam());
  const auto acknack = std::move(Datagram{GetParam()}.add_destination(server).add_acknack(
      5, 0, -1, kPublicationsReader, kPublicationsWriter));
  progress_.sent(acknack.octets(), now_);
  for (std::int64_t number = 6; number < 30'000; number += 1999)
    EXPECT_TRUE(passes(std::move(from_peer().prefix(server).add_data(
        {.reader = kPublicationsReader, .writer = kPublicationsWriter, .number = number},
        payload))))
        << number;
}

TEST_P(Progress, LeavesTheFirstMessagesOfAWriterAlone) {
  acknowledge(0);
  EXPECT_TRUE(passes(heartbeat(100'000, 100'009)));
  EXPECT_TRUE(passes(sample(100'010)));
}

// A late joiner asks until it has what exists; each answer takes it a step further.
TEST_P(Progress, BringsAReaderToAWriterThatIsFarAhead) {
  constexpr std::int64_t kFar = 100'000'000;
  acknowledge(0);
  std::int64_t first = 0;
  std::uint32_t count = 0;
  int answers = 0;
  for (; first < kFar && answers < 100; ++answers) {
    const Octets octets = narrowed(heartbeat(kFar, kFar + 9, ++count));
    ASSERT_EQ(taken_, 0);
    const auto passed = first_of(octets).sequence_number(8);
    ASSERT_LE(passed - std::max<std::int64_t>(first, 1), ReaderProgress::kStep);
    first = passed;
    acknowledge(first);
    if (first < kFar) {
      EXPECT_EQ(first_of(narrowed(sample(kFar + 9))).id, 0x7f) << "beyond the window";
      EXPECT_EQ(taken_, 0) << "but no sign of an attack";
    }
  }
  EXPECT_EQ(first, kFar);
  EXPECT_EQ(answers, 24);
}

TEST_P(Progress, ShortensTheLeapOfAWriterThatItDoesNotKnow) {
  const Octets octets = narrowed(heartbeat(100'000'000, 100'000'009));
  EXPECT_EQ(taken_, 0);
  EXPECT_EQ(first_of(octets).sequence_number(8), 1 + ReaderProgress::kStep);
}

// A GAP from what the reader waits for to anywhere: what is old does not exist any more.
TEST_P(Progress, RewritesAWideGapAsAHeartbeat) {
  acknowledge(7);
  EXPECT_TRUE(passes(heartbeat(1, 7, 41)));
  now_ += 60.0;
  for (int i = 0; i < 2; ++i, now_ += 0.06)
    EXPECT_TRUE(is_removed(from_peer().add_gap(7, 5000, 0)));
  const Octets octets = narrowed(from_peer().add_gap(7, 5000, 64));
  const auto heartbeat = first_of(octets);
  EXPECT_EQ(taken_, 0);
  EXPECT_EQ(heartbeat.id, rt::rtps_message::kHeartbeat);
  EXPECT_EQ(heartbeat.sequence_number(8), 5000);
  EXPECT_EQ(heartbeat.sequence_number(16), 4999);
  EXPECT_EQ(heartbeat.u32(24), 42u) << "above the writer's last";
  EXPECT_TRUE(passes(sample(5000)));
}

TEST_P(Progress, CutsAWideGapThatBeginsLaterThanTheReaderWaitsFor) {
  acknowledge(7);
  EXPECT_TRUE(passes(heartbeat(7, 30)));
  now_ += 60.0;
  const auto gap = [] { return std::move(from_peer().add_gap(50, 400, 64)); };
  for (int i = 0; i < 2; ++i, now_ += 0.06) EXPECT_TRUE(is_removed(gap())) << "a leap";
  const Octets octets = narrowed(gap());
  const auto cut = first_of(octets);
  EXPECT_EQ(cut.id, rt::rtps_message::kGap);
  EXPECT_EQ(cut.sequence_number(16), 50 + ReaderProgress::kWide);
  EXPECT_EQ(cut.u32(24), 0u);
}

TEST_P(Progress, CutsAWideGapOfAWriterThatItDoesNotKnow) {
  const Octets octets = narrowed(from_peer().add_gap(1, 100'000'000, 0));
  EXPECT_EQ(first_of(octets).sequence_number(16), 1 + ReaderProgress::kWide);
}

TEST_P(Progress, RemovesWhatLiesBeyondTheWindow) {
  acknowledge(7);
  const std::int64_t beyond = 8 + ReaderProgress::kWindow;
  EXPECT_TRUE(is_removed(sample(beyond)));
  EXPECT_TRUE(is_removed(from_peer().add_gap(beyond, beyond + 5, 0)));
  // After a long outage.
  now_ += 60.0;
  EXPECT_TRUE(is_removed(heartbeat(beyond, beyond + 9, 3)));
  EXPECT_TRUE(is_removed(heartbeat(beyond, beyond + 9, 4)));
  now_ += 0.2;
  EXPECT_TRUE(passes(heartbeat(beyond, beyond + 9, 5)));
  EXPECT_TRUE(passes(sample(beyond)));
}

// Damage to `last` alone must not make the reader ask for numbers that do not exist.
TEST_P(Progress, ShortensAHeartbeatWhoseLastNumberLeaps) {
  acknowledge(7);
  EXPECT_TRUE(passes(heartbeat(1, 9, 1)));
  const Octets octets = narrowed(heartbeat(1, 1'000'000, 2));
  EXPECT_EQ(taken_, 0);
  EXPECT_EQ(first_of(octets).sequence_number(8), 1);
  EXPECT_EQ(first_of(octets).sequence_number(16), 9 + WriterReach::kLeap);
}

// libFuzzer found the sum of this number and a leap.
TEST_P(Progress, IgnoresAnAcknowledgementThatNoWriterReaches) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  acknowledge(kMost);
  const Octets octets = narrowed(heartbeat(1, kMost));
  EXPECT_EQ(taken_, 0);
  EXPECT_LE(first_of(octets).sequence_number(16), WriterReach::kLeap);
}

TEST_P(Progress, KnowsANumberBeyondAllThatAReaderWasTold) {
  const auto beyond = [&] { return progress_.beyond(rt::prefix_at(kPeer.data()), 0x00001203); };
  EXPECT_GT(beyond(), ReaderProgress::kStep) << "a HEARTBEAT may have taken it there";
  acknowledge(7);
  const std::int64_t farthest = 7 + ReaderProgress::kWindow;
  EXPECT_TRUE(passes(from_peer().add_gap(8, 30, 0)));
  const std::int64_t unforged = beyond();
  EXPECT_GT(unforged, farthest);
  for (std::int64_t last = 30; last < 1'000'000; last += WriterReach::kLeap)
    (void)narrowed(heartbeat(1, last));  // forged
  EXPECT_EQ(beyond(), unforged);
}

// A reader ignores counts that are not above the last one.
TEST_P(Progress, RenumbersHeartbeatsAfterAForgedCount) {
  const auto count_of = [&](std::uint32_t count) {
    return first_of(narrowed(heartbeat(1, 9, count))).u32(24);
  };
  acknowledge(7);
  EXPECT_EQ(count_of(100), 100u);
  EXPECT_EQ(count_of(100), 100u) << "the same one, received again";
  EXPECT_EQ(count_of(0xffffff00), 101u);
  EXPECT_EQ(count_of(101), 102u);
  EXPECT_EQ(count_of(102), 103u);
}

TEST_P(Progress, DoesNotStartAtAForgedCountThatLeavesNoneAbove) {
  acknowledge(7);
  const auto first = first_of(narrowed(heartbeat(1, 9, 0xffffffff))).u32(24);
  EXPECT_LT(first, 0x80000000u);
  EXPECT_EQ(first_of(narrowed(heartbeat(1, 9, 5))).u32(24), first + 1);
}

// The reader rarely acknowledges while nothing is lost.
TEST_P(Progress, FollowsWhatArrivesInOrder) {
  acknowledge(1);
  for (std::int64_t number = 1; number < 3 * ReaderProgress::kWindow; ++number)
    ASSERT_TRUE(passes(sample(number))) << number;
}

TEST_P(Progress, FollowsTheReaderThatIsFarthestBehind) {
  acknowledge(10'000);
  acknowledge(5, 0x00001304);
  EXPECT_TRUE(is_removed(sample(10'000)));  // to all readers
  EXPECT_TRUE(passes(sample(10'000, kReader)));
}

// Otherwise forged GUIDs would make the guard forget where the true writers are.
TEST_P(Progress, RemembersAWriterThatItAnsweredAmongForgedOnes) {
  acknowledge(7);
  for (int i = 0; i < 50'000; ++i) {
    Octets stranger = kPeer;
    std::memcpy(stranger.data(), &i, sizeof i);
    (void)narrowed(Datagram{GetParam()}.prefix(stranger).add_data({.number = 1}, Octets(8, 1)));
  }
  EXPECT_TRUE(is_removed(sample(5000)));
}

// A writer of 100 samples a second amid 20 damaged copies of each message, of which the damage hits
// the numbers more often than it would by chance.
TEST_P(Progress, FollowsTheWriterAfterAnyDamage) {
  std::mt19937 random{GetParam() ? 1U : 2U};
  const auto damaged = [&](const Datagram& datagram) {
    Octets octets = datagram.octets();
    const std::size_t numbers = octets.size() - 28;
    const std::size_t at = random() % 4 == 0 ? random() % octets.size() : numbers + random() % 28;
    octets[at] = static_cast<std::uint8_t>(octets[at] ^ 1U << random() % 8);
    return octets;
  };
  acknowledge(0);
  std::int64_t number = 5000;
  std::int64_t highest = 0;  // what a best-effort reader has seen
  const auto deliver = [&](Octets octets) {
    if (rt::check_datagram(octets, {}) != rt::Drop::kNone) return;
    const std::uint8_t* prefix = octets.data() + rt::rtps_message::kPrefixAt;
    if (!std::equal(kPeer.begin(), kPeer.end(), prefix)) return;
    (void)progress_.narrow(octets, now_);
    const auto passed = first_of(octets);
    const bool is_data = passed.id == rt::rtps_message::kData;
    if (is_data && passed.entity(8) == 0x00001203)
      highest = std::max(highest, passed.sequence_number(12));
    if (passed.id == rt::rtps_message::kHeartbeat && passed.entity(4) == 0x00001203)
      highest = std::max(highest, passed.sequence_number(8) - 1);
  };
  deliver(heartbeat(number, number).octets());
  for (std::uint32_t i = 1; i < 20'000; ++i, now_ += 0.01) {
    const Datagram messages[] = {sample(++number), heartbeat(number - 9, number, i)};
    for (const auto& message : messages) deliver(message.octets());
    for (int copies = 0; copies < 20; ++copies) deliver(damaged(messages[copies % 2]));
  }
  EXPECT_LT(highest, number + 20 * WriterReach::kLeap);
  for (int i = 0; i < 1000; ++i, now_ += 0.01) deliver(sample(++number).octets());
  EXPECT_EQ(highest, number) << "a second later it sees the writer's own";
}

}  // namespace
}  // namespace tandem
