// SPDX-License-Identifier: Apache-2.0
// Tests well-formed datagrams that would make Fast DDS keep too much memory.
#include "tandem/runtime/detail/rtps_watch.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "runtime/datagram.hpp"
#include "tandem/runtime/detail/rtps_message.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using test::Datagram;
using test::Octets;

const Octets kPeer{9, 8, 7, 6, 5, 4, 3, 2, 1, 0, 1, 2};
constexpr std::uint32_t kReader = 0x00001204;
constexpr std::int64_t kFar =
    100'000'000;  // where a reader joins that a writer has long written to

rt::rtps_message::Submessage first_of(const Octets& octets) {
  rt::rtps_message::Submessage submessage{};
  EXPECT_TRUE(rt::rtps_message::Submessages{octets}.next(submessage));
  return submessage;
}

// In either byte order.
class Progress : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static Datagram from_peer() {
    return std::move(Datagram{GetParam()}.prefix(kPeer));
  }
  void acknowledge(std::int64_t base) {
    progress_.sent(Datagram{GetParam()}.add_destination(kPeer).add_acknack(base, 0).octets());
  }
  // What becomes of it.
  Octets narrowed(const Datagram& datagram) {
    Octets octets = datagram.octets();
    taken_ = progress_.narrow(octets);
    EXPECT_EQ(rt::check_datagram(octets, {}), rt::Drop::kNone);
    return octets;
  }
  // Such as must come twice.
  Octets narrowed_again(const Datagram& datagram) {
    (void)narrowed(datagram);
    EXPECT_EQ(taken_, 1);
    return narrowed(datagram);
  }
  bool passes(const Datagram& datagram) {
    return narrowed(datagram) == datagram.octets() && taken_ == 0;
  }

  rt::ReaderProgress progress_;
  int taken_ = 0;
};
INSTANTIATE_TEST_SUITE_P(Orders, Progress, testing::Bool());

TEST_P(Progress, LeavesUsualTrafficUnchanged) {
  acknowledge(5);
  EXPECT_TRUE(passes(from_peer().add_data({.number = 5}, Octets(8, 1))));
  EXPECT_TRUE(passes(from_peer().add_gap(6, 30, 32)));
  EXPECT_TRUE(passes(from_peer().add_heartbeat(5, 200)));
  EXPECT_TRUE(passes(from_peer().add_data({.number = 20}, Octets(8, 1))));
}

TEST_P(Progress, LeavesUnacknowledgedWritersAlone) {
  acknowledge(0);
  EXPECT_TRUE(passes(from_peer().add_data({.number = kFar}, Octets(8, 1))));
  EXPECT_TRUE(passes(from_peer().add_heartbeat(kFar, kFar + 9)));
  EXPECT_TRUE(passes(from_peer().add_gap(kFar, kFar + 10, 0)));
}

// A GAP from what the reader waits for to anywhere: what is old does not exist any more.
TEST_P(Progress, RewritesAWideGapAsAHeartbeat) {
  acknowledge(7);
  const Octets octets = narrowed_again(from_peer().add_gap(7, kFar, 64));
  const auto heartbeat = first_of(octets);
  EXPECT_EQ(heartbeat.id, rt::rtps_message::kHeartbeat);
  EXPECT_EQ(heartbeat.sequence_number(8), kFar);
  EXPECT_EQ(heartbeat.sequence_number(16), kFar - 1);
  EXPECT_EQ(heartbeat.u32(24), 1u);
  EXPECT_EQ(taken_, 0);
  EXPECT_TRUE(passes(from_peer().add_data({.number = kFar}, Octets(8, 1))));  // it is followed
}

TEST_P(Progress, CountsThatHeartbeatOnFromTheWritersLast) {
  acknowledge(7);
  EXPECT_TRUE(passes(from_peer().add_heartbeat(1, 9, 41)));
  EXPECT_EQ(first_of(narrowed_again(from_peer().add_gap(7, kFar, 0))).u32(24), 42u);
}

TEST_P(Progress, CutsAWideGapThatBeginsLaterThanTheReaderWaitsFor) {
  acknowledge(7);
  const Octets octets = narrowed_again(from_peer().add_gap(50, kFar, 64));
  const auto gap = first_of(octets);
  EXPECT_EQ(gap.id, rt::rtps_message::kGap);
  EXPECT_EQ(gap.sequence_number(16), 50 + rt::ReaderProgress::kWide);
  EXPECT_EQ(gap.u32(24), 0u);
}

TEST_P(Progress, CutsAWideGapOfAWriterThatItDoesNotKnow) {
  const Octets octets = narrowed(from_peer().add_gap(1, kFar, 0));
  EXPECT_EQ(first_of(octets).sequence_number(16), 1 + rt::ReaderProgress::kWide);
}

TEST_P(Progress, TakesOutWhatLiesBeyondTheWindow) {
  acknowledge(7);
  const std::int64_t beyond = 8 + rt::ReaderProgress::kWindow;
  (void)narrowed(from_peer().add_data({.number = beyond}, Octets(8, 1)).add_heartbeat(7, 9));
  EXPECT_EQ(taken_, 1);
  (void)narrowed(from_peer().add_gap(beyond, beyond + 5, 0));
  EXPECT_EQ(taken_, 1);
  // After a long outage.
  const auto heartbeat = [&](std::uint32_t count) {
    return std::move(from_peer().add_heartbeat(beyond, beyond + 9, count));
  };
  EXPECT_FALSE(passes(heartbeat(3)));
  EXPECT_FALSE(passes(heartbeat(3))) << "the same one";
  EXPECT_TRUE(passes(heartbeat(4)));
  EXPECT_TRUE(passes(from_peer().add_data({.number = beyond}, Octets(8, 1))));
}

TEST_P(Progress, RejectsASingleLeapingSampleOfAnUnacknowledgedWriter) {
  const auto sample = [](std::int64_t number) {
    return std::move(from_peer().add_data({.number = number}, Octets(8, 1)));
  };
  EXPECT_TRUE(passes(sample(1000)));
  EXPECT_TRUE(passes(sample(1030)));  // some were lost
  EXPECT_FALSE(passes(sample(5000)));
  EXPECT_FALSE(passes(sample(5000)));
  EXPECT_TRUE(passes(sample(1031)));
  EXPECT_FALSE(passes(sample(1300)));  // after an outage
  EXPECT_TRUE(passes(sample(1301)));
}

TEST_P(Progress, RejectsASingleLeapingHeartbeat) {
  acknowledge(7);
  EXPECT_TRUE(passes(from_peer().add_heartbeat(7, 9, 100)));
  EXPECT_TRUE(passes(from_peer().add_heartbeat(20, 29, 101)));  // a few were lost
  for (const std::int64_t first : {1'000, 50'000'000, 80}) {
    (void)narrowed(from_peer().add_heartbeat(first, first + 9, 102));
    EXPECT_EQ(taken_, 1) << first;
  }
  (void)narrowed(from_peer().add_heartbeat(20, 29, 0x40000000));
  EXPECT_EQ(taken_, 1) << "the reader would ignore one with a smaller count";
  EXPECT_TRUE(
      passes(from_peer().add_data({.number = 20}, Octets(8, 1)).add_heartbeat(20, 29, 103)));
}

// The reader rarely acknowledges while nothing is lost.
TEST_P(Progress, FollowsWhatArrivesInOrder) {
  acknowledge(1);
  for (std::int64_t number = 1; number < 3 * rt::ReaderProgress::kWindow; ++number)
    ASSERT_TRUE(passes(from_peer().add_data({.number = number}, Octets(8, 1)))) << number;
}

TEST_P(Progress, TakesTheLastNumberThatThereIs) {
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  acknowledge(0);
  EXPECT_TRUE(passes(from_peer().add_data({.number = kLast}, Octets(8, 1))));
  EXPECT_TRUE(passes(from_peer().add_data({.number = kLast}, Octets(8, 1))));
}

TEST_P(Progress, FollowsTheReaderThatIsFarthestBehind) {
  acknowledge(10'000);
  progress_.sent(
      Datagram{GetParam()}.add_destination(kPeer).add_acknack(5, 0, -1, 0x00001304).octets());
  (void)narrowed(from_peer().add_data({.number = 10'000}, Octets(8, 1)));  // to all readers
  EXPECT_EQ(taken_, 1);
  EXPECT_TRUE(passes(from_peer().add_data({.reader = kReader, .number = 10'000}, Octets(8, 1))));
}

// --- announcements
// ----------------------------------------------------------------------------------

constexpr std::uint32_t kSpdp = 0x000100c2, kPublications = 0x000003c2;

Octets stranger(int number) {
  Octets prefix(12, 7);
  std::memcpy(prefix.data() + 8, &number, sizeof number);
  return prefix;
}

Datagram participant(int number, std::uint32_t lease = 20) {
  Octets duration;
  test::append(duration, lease, true);
  test::append(duration, std::uint32_t{0}, true);
  return std::move(Datagram{}
                       .prefix(stranger(number))
                       .add_announcement(kSpdp, {{0x50, Octets(16, 1)}, {0x02, duration}}));
}

Datagram endpoint(int participant, std::int64_t number) {
  Octets payload{0, 3, 0, 0, 1, 0, 0, 0};
  return std::move(Datagram{}
                       .prefix(stranger(participant))
                       .add_data({.writer = kPublications, .number = number}, payload));
}

class AnnouncementsTest : public testing::Test {
 protected:
  bool admits(const Datagram& datagram, double now) {
    Octets octets = datagram.octets();
    return announcements_.thin(octets, now) == 0;
  }
  rt::Announcements announcements_;
};

TEST_F(AnnouncementsTest, PassAsUsualAndAgain) {
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(admits(participant(i), 1.0)) << i;
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(admits(participant(i), 1.0)) << i;
  for (int i = 1; i < 500; ++i) EXPECT_TRUE(admits(endpoint(3, i), 1.0)) << i;
}

TEST_F(AnnouncementsTest, OfManyParticipantsAreThinned) {
  int admitted = 0;
  for (int i = 0; i < 100'000; ++i) admitted += admits(participant(i), 10.0 + 1e-4 * i) ? 1 : 0;
  EXPECT_LT(admitted, 200);
}

TEST_F(AnnouncementsTest, OfAParticipantThatRepeatsItselfPassAmongMany) {
  int other = 1;
  bool joined = false;
  for (int tick = 0; tick < 30 && !joined; ++tick) {  // of 0.1 s, as a real one announces itself
    for (int i = 0; i < 2000; ++i) (void)admits(participant(++other), 10.0 + 0.1 * tick);
    joined = admits(participant(0), 10.0 + 0.1 * tick) && tick > 0;
  }
  EXPECT_TRUE(joined);
}

TEST_F(AnnouncementsTest, OfManyEndpointsAreThinned) {
  int admitted = 0;
  for (int i = 0; i < 50; ++i) (void)admits(participant(i), 1.0);
  for (int i = 0; i < 100'000; ++i) admitted += admits(endpoint(i % 50, 1 + i / 50), 2.0) ? 1 : 0;
  EXPECT_LT(admitted, 5000);
  (void)admits(participant(77), 3.0);
  EXPECT_TRUE(admits(endpoint(77, 1), 3.0)) << "a few of each participant pass always";
}

TEST_F(AnnouncementsTest, CannotUseANumberThatIsFarAheadToPassTheOthers) {
  (void)admits(participant(0), 1.0);
  (void)admits(endpoint(0, 1'000'000), 1.0);
  int admitted = 0;
  for (int i = 1; i < 10'000; ++i) admitted += admits(endpoint(0, i), 1.0) ? 1 : 0;
  EXPECT_LT(admitted, 3000);
}

TEST_F(AnnouncementsTest, AreKeptForAHundredSecondsAtMost) {
  Octets octets = participant(0, 0x7fffffff).octets();
  EXPECT_EQ(announcements_.thin(octets, 1.0), 0);
  EXPECT_EQ(octets, participant(0, 100).octets());
  EXPECT_EQ(rt::check_datagram(octets, {}), rt::Drop::kNone);
}

}  // namespace
}  // namespace tandem
