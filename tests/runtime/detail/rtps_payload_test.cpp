// SPDX-License-Identifier: Apache-2.0
// Tests which announcements, liveliness and security messages pass. Instantiated in
// rtps_guard_test.cpp.
#include "tandem/runtime/detail/rtps_payload.hpp"

#include "runtime/detail/guard_checks.hpp"

namespace tandem {
namespace rt = runtime;
namespace {

using rt::check_datagram;
using rt::Drop;
using test::append;
using test::check;
using test::Datagram;
using test::InBothOrders;
using test::kLimits;
using test::Octets;
using test::Parameters;

// --- discovery ---

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

// --- DDS Security ---

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
