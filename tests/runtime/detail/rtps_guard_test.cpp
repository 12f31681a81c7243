// SPDX-License-Identifier: Apache-2.0
// Tests which datagrams pass: all that DDS implementations send, and none that are inconsistent.
#include "tandem/runtime/detail/rtps_guard.hpp"

#include "runtime/detail/guard_checks.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using rt::Drop;
using test::check;
using test::Datagram;
using test::InBothOrders;
using test::Octets;

std::string kind_of(const Octets& octets) { return rt::name(check(octets)); }

INSTANTIATE_TEST_SUITE_P(RtpsGuard, InBothOrders, testing::Bool(), [](const auto& test) {
  return std::string{test.param ? "LittleEndian" : "BigEndian"};
});

// --- recorded ---

TEST(RtpsGuard, DropsEveryDatagramKnownToCrashAProcess) {
  const auto files = test::datagram_files("hostile");
  ASSERT_GE(files.size(), 6u);
  for (const auto& file : files) EXPECT_NE(kind_of(test::read(file)), "none") << file;
}

TEST(RtpsGuard, PassesWhatFastDdsCycloneDdsAndRclpySent) {
  const auto files = test::datagram_files("sessions");
  ASSERT_GE(files.size(), 40u);
  for (const auto& file : files) EXPECT_EQ(kind_of(test::read(file)), "none") << file;
}

TEST(RtpsGuard, DropsEveryTruncationInsideASubmessage) {
  for (const auto& file : test::datagram_files("sessions")) {
    Octets octets = test::read(file);
    const auto ends = test::submessage_ends(octets);
    for (std::size_t size = octets.size() - 1; size > 20; --size) {
      octets.resize(size);
      if (!ends.contains(size)) {
        EXPECT_NE(kind_of(octets), "none") << file << ' ' << size;
      }
    }
  }
}

// --- header and submessages ---

TEST(RtpsGuard, RequiresAnRtps2Header) {
  EXPECT_EQ(check(Octets{}), Drop::kHeader);
  EXPECT_EQ(check(Octets(19, 'R')), Drop::kHeader);
  Octets octets = Datagram{}.octets();
  EXPECT_EQ(check(octets), Drop::kNone);
  octets[5] = 9;  // a newer minor version
  EXPECT_EQ(check(octets), Drop::kNone);
  octets[4] = 3;
  EXPECT_EQ(check(octets), Drop::kHeader);
  octets[0] = 'X';
  EXPECT_EQ(check(octets), Drop::kHeader);
}

TEST_P(InBothOrders, SkipsSubmessagesItDoesNotKnow) {
  for (const int id : {0x00, 0x02, 0x30, 0x33, 0x55, 0x7f})
    EXPECT_EQ(
        check(
            datagram().add(static_cast<std::uint8_t>(id), 0, Octets(8, 0xff)).add_heartbeat(1, 5)),
        Drop::kNone)
        << id;
}

TEST_P(InBothOrders, TakesTheRestOfTheDatagramForALengthOfZero) {
  EXPECT_EQ(check(datagram().add_data({}, Octets(8, 1)).without_last_length()), Drop::kNone);
  EXPECT_EQ(check(datagram().add_heartbeat(5, 1).without_last_length()), Drop::kNumberSet);
  // … but not for these two, which may be empty
  EXPECT_EQ(check(datagram().add(0x01, 0, {}).add(0x09, 2, {}).add_heartbeat(5, 1)),
            Drop::kNumberSet);
}

TEST_P(InBothOrders, RequiresWholeSubmessages) {
  Octets octets = datagram().add_heartbeat(1, 5).octets();
  octets.pop_back();
  EXPECT_EQ(check(octets), Drop::kSubmessage);
  octets.push_back(0);
  octets.push_back(7);
  EXPECT_EQ(check(octets), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add(0x0e, 0, Octets(8, 1))), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add(0x0c, 0, Octets(16, 1))), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add(0x09, 0, Octets(4, 1))), Drop::kSubmessage);
}

// --- data ---

TEST_P(InBothOrders, PassesDataWithAndWithoutInlineQos) {
  EXPECT_EQ(check(datagram().add_data({}, Octets(1, 1))), Drop::kNone);
  EXPECT_EQ(check(datagram().add_data({.inline_qos = {{0x83, Octets(24, 1)}}}, Octets(40, 1))),
            Drop::kNone);
  EXPECT_EQ(check(datagram().add_data({.extra = 8}, Octets(8, 1))), Drop::kNone);
  EXPECT_EQ(check(datagram().add_data({.flags = 8}, Octets(16, 1))), Drop::kNone);  // a key
  EXPECT_EQ(check(datagram().add_data({.flags = 0}, {})), Drop::kNone);
}

TEST_P(InBothOrders, DropsDataWhoseInlineQosExceedsTheSubmessage) {
  EXPECT_EQ(check(datagram().add_data({.to_inline_qos = 0}, Octets(8, 1))), Drop::kInlineQos);
  EXPECT_EQ(check(datagram().add_data({.to_inline_qos = 0xffff}, Octets(8, 1))), Drop::kInlineQos);
  EXPECT_EQ(check(datagram().add_data({.to_inline_qos = 26}, Octets(8, 1))), Drop::kInlineQos);
  EXPECT_EQ(check(datagram().add_data({.flags = 4 | 2}, Octets(8, 1))), Drop::kInlineQos);
  // Long enough for the datagram, not for its submessage.
  EXPECT_EQ(check(datagram()
                      .add_data({.flags = 2, .to_inline_qos = 16}, {0x70, 0, 0, 40})
                      .add_data({}, Octets(80, 0))),
            Drop::kInlineQos);
}

TEST_P(InBothOrders, DropsDataWithoutPayloadOrNumber) {
  EXPECT_EQ(check(datagram().add_data({}, {})), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add_data({.flags = 4 | 8}, Octets(8, 1))), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add_data({.number = 0}, Octets(8, 1))), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add_data({.number = -5}, Octets(8, 1))), Drop::kSubmessage);
}

TEST_P(InBothOrders, PassesFragmentsThatFit) {
  const test::Fragment middle{.first = 2, .count = 1, .size = 1000, .sample = 2500};
  EXPECT_EQ(check(datagram().add_data_frag(middle, Octets(1000, 1))), Drop::kNone);
  const test::Fragment last{.first = 2, .count = 2, .size = 1000, .sample = 2500};
  EXPECT_EQ(check(datagram().add_data_frag(last, Octets(1500, 1))), Drop::kNone);
  test::Fragment reply = last;  // as a large service reply has them
  reply.inline_qos = {{0x83, Octets(24, 1)}};
  EXPECT_EQ(check(datagram().add_data_frag(reply, Octets(1500, 1))), Drop::kNone);
}

TEST_P(InBothOrders, DropsFragmentsThatContradictThemselves) {
  const Octets bytes(1000, 1);
  const auto of = [&](test::Fragment fragment) {
    return check(datagram().add_data_frag(fragment, bytes));
  };
  const test::Fragment good{.first = 1, .count = 1, .size = 1000, .sample = 2500};
  EXPECT_EQ(of(good), Drop::kNone);
  const auto changed = [&](auto change) {
    test::Fragment bad = good;
    change(bad);
    return of(bad);
  };
  EXPECT_EQ(changed([](auto& f) { f.first = 0; }), Drop::kFragment);
  EXPECT_EQ(changed([](auto& f) { f.first = 4; }), Drop::kFragment);
  EXPECT_EQ(changed([](auto& f) { f.first = 0xffffffff, f.count = 2; }), Drop::kFragment);
  EXPECT_EQ(changed([](auto& f) { f.count = 0; }), Drop::kFragment);
  EXPECT_EQ(changed([](auto& f) { f.count = 2; }), Drop::kFragment);  // too few bytes
  EXPECT_EQ(changed([](auto& f) { f.size = 0; }), Drop::kFragment);
  EXPECT_EQ(changed([](auto& f) { f.size = 3; }), Drop::kFragment);
  EXPECT_EQ(changed([](auto& f) { f.sample = 0; }), Drop::kFragment);
  EXPECT_EQ(changed([](auto& f) { f.sample = (1U << 20) + 1; }), Drop::kSampleSize);
  EXPECT_EQ(changed([](auto& f) { f.number = 0; }), Drop::kSubmessage);
  EXPECT_EQ(changed([](auto& f) { f.to_inline_qos = 16; }), Drop::kInlineQos);
  EXPECT_EQ(changed([](auto& f) { f.writer = 0x000100c2, f.sample = 70'000; }), Drop::kSampleSize);
}

// Fast DDS keeps numbers in the sample's memory, at the next multiple of four of each fragment.
TEST_P(InBothOrders, DropsAFragmentWhoseListExceedsTheSample) {
  const test::Fragment tiny_end{.first = 1, .count = 2, .size = 1001, .sample = 1002};
  EXPECT_EQ(check(datagram().add_data_frag(tiny_end, Octets(1002, 1))), Drop::kFragment);
  const test::Fragment usual{.first = 1, .count = 2, .size = 1000, .sample = 1001};
  EXPECT_EQ(check(datagram().add_data_frag(usual, Octets(1001, 1))), Drop::kNone);
}

// --- acknowledgements ---

TEST_P(InBothOrders, RequiresSetsOfAtMost256PresentNumbers) {
  EXPECT_EQ(check(datagram().add_acknack(0, 0)), Drop::kNone);
  EXPECT_EQ(check(datagram().add_acknack(7, 256)), Drop::kNone);
  EXPECT_EQ(check(datagram().add_acknack(7, 257)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_acknack(7, 256, 7)), Drop::kNumberSet);  // one word too few
  EXPECT_EQ(check(datagram().add_acknack(-1, 0)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_nack_frag(3, 1, 40)), Drop::kNone);
  EXPECT_EQ(check(datagram().add_nack_frag(3, 0, 40)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_nack_frag(0, 1, 40)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_nack_frag(3, 1, 300)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_gap(3, 100'000'000, 256)), Drop::kNone);  // wide is legitimate
  EXPECT_EQ(check(datagram().add_gap(0, 5, 0)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_gap(6, 5, 0)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_gap(3, 5, 1000)), Drop::kNumberSet);
}

TEST_P(InBothOrders, RequiresHeartbeatsWithPossibleSamples) {
  EXPECT_EQ(check(datagram().add_heartbeat(1, 0)), Drop::kNone);  // nothing written yet
  EXPECT_EQ(check(datagram().add_heartbeat(100'000'000, 100'000'009)), Drop::kNone);
  EXPECT_EQ(check(datagram().add_heartbeat(0, 5)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add_heartbeat(9, 5)), Drop::kNumberSet);
  EXPECT_EQ(check(datagram().add(0x07, 0, Octets(24, 0))), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add(0x13, 0, Octets(20, 0))), Drop::kSubmessage);
  EXPECT_EQ(check(datagram().add(0x13, 0, Octets(24, 0))), Drop::kNumberSet);
}

// --- statistics ---

TEST_P(InBothOrders, PassesStatisticsOnlyAsFastDdsWritesThem) {
  constexpr std::uint16_t kEprosima = 0x010f, kOther = 0x0110;
  const Octets right(56, 0), wrong(60, 0);
  const auto of = [&](std::uint16_t vendor, const Octets& body) {
    return datagram().vendor(vendor).add_heartbeat(1, 5).add(0x80, 0, body);
  };
  EXPECT_EQ(check(of(kEprosima, right)), Drop::kNone);
  EXPECT_EQ(check(of(kEprosima, wrong)), Drop::kStatistics);
  EXPECT_EQ(check(of(kEprosima, right).add_heartbeat(1, 5)), Drop::kStatistics);
  EXPECT_EQ(check(of(kOther, wrong).add_heartbeat(1, 5)), Drop::kNone);
}

}  // namespace
}  // namespace tandem
