// SPDX-License-Identifier: Apache-2.0
// Tests which datagrams pass: all that DDS implementations send, and none that are inconsistent.
#include "tandem/runtime/detail/rtps_guard.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "runtime/datagram.hpp"
#include "support/paths.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using rt::check_datagram;
using rt::Drop;
using test::append;
using test::Datagram;
using test::Octets;
using test::Parameters;

const rt::GuardLimits kLimits{.sample_size = 1U << 20, .discovery_size = 1U << 16};

Drop check(const Octets& octets) { return check_datagram(octets, kLimits); }
Drop check(const Datagram& datagram) { return check(datagram.octets()); }

std::string kind_of(const Octets& octets) { return rt::name(check(octets)); }

// Every statement about a datagram must hold in both byte orders.
class InBothOrders : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static Datagram datagram() { return Datagram{GetParam()}; }
};
INSTANTIATE_TEST_SUITE_P(RtpsGuard, InBothOrders, testing::Bool(), [](const auto& test) {
  return std::string{test.param ? "LittleEndian" : "BigEndian"};
});

// --- recorded
// --------------------------------------------------------------------------------------

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

// --- header and submessages
// -----------------------------------------------------------------------

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

// --- data
// ---------------------------------------------------------------------------------------------

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

// --- acknowledgements
// -------------------------------------------------------------------------------

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

// --- discovery
// ----------------------------------------------------------------------------------------

constexpr std::uint32_t kSpdp = 0x000100c2, kLiveliness = 0x000200c2;

TEST_P(InBothOrders, RequiresAnnouncementsWhoseValuesFit) {
  const auto announced = [&](const test::Parameters& parameters) {
    return check(datagram().add_announcement(kSpdp, parameters));
  };
  const auto text = [&](std::uint32_t length) {
    Octets octets;
    test::append(octets, length, GetParam());
    octets.insert(octets.end(), 4, 'a');
    return octets;
  };
  EXPECT_EQ(announced({{0x50, Octets(16, 1)}, {0x62, text(4)}, {0x8123, Octets(5, 1)}}),
            Drop::kNone);
  EXPECT_EQ(announced({{0x50, Octets(12, 1)}}), Drop::kDiscovery);
  EXPECT_EQ(announced({{0x62, text(5)}}), Drop::kDiscovery);
  EXPECT_EQ(announced({{0x2c, text(0xffffffff)}}), Drop::kDiscovery);
  EXPECT_EQ(announced({{0x59, text(2)}}), Drop::kDiscovery);
  EXPECT_EQ(announced({{0x29, text(0x7fffffff)}}), Drop::kDiscovery);
  EXPECT_EQ(announced({{0x31, Octets(20, 1)}}), Drop::kDiscovery);
}

// CVE-2024-30258: a token of DDS Security says how many properties follow.
TEST_P(InBothOrders, DropsTokensWhoseCountsExceedTheirBytes) {
  const auto token = [&](std::uint32_t texts, std::uint32_t binaries) {
    Octets octets;
    for (const std::uint32_t number : {4U, 0x00636261U, texts, binaries})  // "abc", two counts
      test::append(octets, number, GetParam());
    return octets;
  };
  for (const auto id : std::initializer_list<std::uint16_t>{0x1001, 0x1002, 0x1006}) {
    const auto announced = [&](const Octets& value) {
      return check(datagram().add_announcement(kSpdp, {{id, value}}));
    };
    EXPECT_EQ(announced(token(0, 0)), Drop::kNone);
    for (const std::uint32_t count : {1U, 0x10000U, 0x7fffffffU, 0xffffffffU}) {
      EXPECT_EQ(announced(token(count, 0)), Drop::kDiscovery) << count;
      EXPECT_EQ(announced(token(0, count)), Drop::kDiscovery) << count;
    }
  }
}

TEST_P(InBothOrders, RequiresAnnouncementsToBeParameterLists) {
  const auto payload = [&](Octets octets) {
    return check(datagram().add_data({.writer = kSpdp}, octets));
  };
  EXPECT_EQ(payload({0, 3, 0, 0, 1, 0, 0, 0}), Drop::kNone);
  EXPECT_EQ(payload({0, 2, 0, 0, 0, 1, 0, 0}), Drop::kNone);
  EXPECT_EQ(payload({0, 1, 0, 0, 1, 0, 0, 0}), Drop::kDiscovery);
  EXPECT_EQ(payload({0, 3, 0, 0}), Drop::kDiscovery);
  EXPECT_EQ(payload({0}), Drop::kDiscovery);
  EXPECT_EQ(payload({0, 3, 0, 0, 0x50, 0, 0xff, 0xff, 1, 0, 0, 0}), Drop::kDiscovery);
}

TEST_P(InBothOrders, RequiresLivelinessToNameItsParticipant) {
  EXPECT_EQ(check(datagram().add_data({.writer = kLiveliness}, Octets(28, 1))), Drop::kNone);
  EXPECT_EQ(check(datagram().add_data({.writer = kLiveliness}, Octets(12, 1))), Drop::kDiscovery);
}

// --- statistics
// -----------------------------------------------------------------------------------------

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

// --- DDS Security
// --------------------------------------------------------------------------------------

constexpr std::uint32_t kStateless = 0x000201c3, kVolatile = 0xff0202c3;

Octets cdr_text(const std::string& text, bool little) {
  Octets octets;
  append(octets, static_cast<std::uint32_t>(text.size() + 1), little);
  octets.insert(octets.end(), text.begin(), text.end());
  octets.resize((octets.size() + 4) / 4 * 4);
  return octets;
}

// A token with one property of each kind, whose lists say they have so many.
Octets token(bool little, std::uint32_t properties = 1, std::uint32_t binary = 1,
             std::uint32_t octets_in_binary = 8) {
  Octets octets = cdr_text("DDS:Auth:PKI-DH:1.0+Req", little);
  const auto add = [&](const Octets& more) {
    octets.insert(octets.end(), more.begin(), more.end());
  };
  append(octets, properties, little);
  add(cdr_text("name", little));
  add(cdr_text("value", little));
  append(octets, binary, little);
  add(cdr_text("c.id", little));
  append(octets, octets_in_binary, little);
  octets.insert(octets.end(), 8, 0x5a);
  return octets;
}

// A ParticipantGenericMessage that says it has so many tokens.
Octets security_message(bool little, std::uint32_t count, const Octets& tokens) {
  Octets octets{0, static_cast<std::uint8_t>(little ? 1 : 0), 0, 0};
  octets.insert(octets.end(), 96, 7);
  const Octets kind = cdr_text("dds.sec.auth", little);
  octets.insert(octets.end(), kind.begin(), kind.end());
  append(octets, count, little);
  octets.insert(octets.end(), tokens.begin(), tokens.end());
  return octets;
}

Drop check_security(Datagram datagram, std::uint32_t writer, const Octets& message) {
  return check(datagram.add_data({.writer = writer}, message));
}

TEST_P(InBothOrders, PassesSecurityMessagesAsDdsWritesThem) {
  const bool little = GetParam();
  for (const auto writer : {kStateless, kVolatile}) {
    EXPECT_EQ(check_security(datagram(), writer, security_message(little, 1, token(little))),
              Drop::kNone);
    EXPECT_EQ(check_security(datagram(), writer, security_message(little, 0, {})), Drop::kNone);
  }
}

TEST_P(InBothOrders, DropsSecurityMessagesWhoseCountsExceedTheirBytes) {
  const bool little = GetParam();
  for (const auto writer : {kStateless, kVolatile})
    for (const std::uint32_t lie : {2U, 0x7fffffffU, 0xffffffffU}) {
      const auto check_tokens = [&](std::uint32_t count, const Octets& tokens) {
        return check_security(datagram(), writer, security_message(little, count, tokens));
      };
      EXPECT_EQ(check_tokens(lie, token(little)), Drop::kSecurity);
      EXPECT_EQ(check_tokens(1, token(little, lie + 5)), Drop::kSecurity);
      EXPECT_EQ(check_tokens(1, token(little, 1, lie + 5)), Drop::kSecurity);
      EXPECT_EQ(check_tokens(1, token(little, 1, 1, lie | 0x100U)), Drop::kSecurity);
    }
}

TEST_P(InBothOrders, UnderFullProtectionForgedGoodbyesAreDropped) {
  rt::GuardLimits limits = kLimits;
  limits.all_protected = true;
  const Octets list = Datagram::list_payload({}, GetParam());
  const auto status = [](std::uint8_t flags) { return Parameters{{0x71, {0, 0, 0, flags}}}; };
  const auto goodbye = [&](int kind, const Parameters& inline_qos) {
    const auto one =
        datagram().add_data({.writer = kSpdp, .flags = kind, .inline_qos = inline_qos}, list);
    EXPECT_EQ(check(one), Drop::kNone);
    return check_datagram(one.octets(), limits);
  };
  EXPECT_EQ(goodbye(8, status(3)), Drop::kGoodbye);
  EXPECT_EQ(goodbye(4, status(1)), Drop::kGoodbye);
  EXPECT_EQ(goodbye(4, status(2)), Drop::kGoodbye);
  EXPECT_EQ(goodbye(4, status(0)), Drop::kNone);
  EXPECT_EQ(goodbye(4, {{0x70, Octets(16)}}), Drop::kNone);
}

TEST_P(InBothOrders, DropsCutAndFragmentedSecurityMessages) {
  const bool little = GetParam();
  const Octets whole = security_message(little, 1, token(little));
  for (std::size_t size = 1; size < whole.size(); ++size)
    EXPECT_EQ(check_security(datagram(), kStateless,
                             {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}),
              Drop::kSecurity)
        << size;
  EXPECT_EQ(check(datagram().add_data_frag({.writer = kStateless}, Octets(1000))), Drop::kSecurity);
}

// Datagrams that an outsider may send where the governance protects all of them.
TEST_P(InBothOrders, UnderFullProtectionOnlyDiscoveryAndAuthenticationPassUnprotected) {
  rt::GuardLimits limits = kLimits;
  limits.all_protected = true;
  const auto check_one = [&](const Datagram& one) { return check_datagram(one.octets(), limits); };
  const Octets message = security_message(GetParam(), 1, token(GetParam()));
  EXPECT_EQ(check_one(datagram().add_announcement(kSpdp, {})), Drop::kNone);
  EXPECT_EQ(check_one(datagram().add_data({.writer = kStateless}, message)), Drop::kNone);
  EXPECT_EQ(check_one(datagram().add(0x31, 0, Octets(40))), Drop::kNone);  // SEC_PREFIX
  std::vector<Datagram> all;
  all.push_back(datagram().add_data({}, Octets(8)));
  all.push_back(datagram().add_data_frag({}, Octets(1000)));
  all.push_back(datagram().add_heartbeat(1, 1));
  all.push_back(datagram().add_gap(1, 2, 0));
  all.push_back(datagram().add_acknack(1, 0));
  all.push_back(datagram().add_nack_frag(1, 1, 0));
  all.push_back(datagram().add_announcement(0x000003c2, {}));
  all.push_back(datagram().add_data({.writer = kVolatile}, message));
  all.push_back(datagram().add_data({.reader = 0x00001204, .writer = kSpdp},
                                    Datagram::list_payload({}, GetParam())));
  for (const auto& forged : all) {
    EXPECT_EQ(check_one(forged), Drop::kUnsecured);
    Octets as_protected = datagram().add(0x33, 0, Octets(20)).octets();  // Fast DDS verifies it
    as_protected.insert(as_protected.end(), forged.octets().begin() + 20, forged.octets().end());
    EXPECT_EQ(check_datagram(as_protected, limits), check(forged));
  }
}

}  // namespace
}  // namespace tandem
