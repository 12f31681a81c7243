// SPDX-License-Identifier: Apache-2.0
// Tests announcements of participants and endpoints, true and forged.
#include "tandem/runtime/detail/announcements.hpp"

#include <gtest/gtest.h>

#include "runtime/datagram.hpp"
#include "tandem/runtime/detail/rtps_guard.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using test::Datagram;
using test::Octets;

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
                       .add_announcement(rt::rtps_message::kSpdpWriter,
                                         {{0x50, Octets(16, 1)}, {0x02, duration}}));
}

Datagram endpoint(int participant, std::int64_t number) {
  Octets payload{0, 3, 0, 0, 1, 0, 0, 0};
  return std::move(
      Datagram{}
          .prefix(stranger(participant))
          .add_data({.writer = rt::rtps_message::kSedpPublicationsWriter, .number = number},
                    payload));
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
  EXPECT_LT(admitted, 10'000);
  (void)admits(participant(77), 3.0);
  EXPECT_TRUE(admits(endpoint(77, 1), 3.0)) << "a few of each participant pass always";
}

TEST_F(AnnouncementsTest, CannotUseANumberThatIsFarAheadToPassTheOthers) {
  (void)admits(participant(0), 1.0);
  (void)admits(endpoint(0, 1'000'000), 1.0);
  int admitted = 0;
  for (int i = 1; i < 100'000; ++i) admitted += admits(endpoint(0, i), 1.0) ? 1 : 0;
  EXPECT_LT(admitted, 9000);
}

TEST_F(AnnouncementsTest, AreKeptForAHundredSecondsAtMost) {
  Octets octets = participant(0, 0x7fffffff).octets();
  EXPECT_EQ(announcements_.thin(octets, 1.0), 0);
  EXPECT_EQ(octets, participant(0, 100).octets());
  EXPECT_EQ(rt::check_datagram(octets, {}), rt::Drop::kNone);
}

}  // namespace
}  // namespace tandem
