// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/rtps_guard.hpp"

#include <algorithm>
#include <cstring>

#include "tandem/runtime/detail/rtps_message.hpp"

namespace tandem::runtime {
namespace {

using namespace rtps_message;

constexpr std::uint8_t kVersion = 2;
constexpr std::size_t kMaxBits = 256;         // maximum bits of a number set
constexpr std::size_t kLeastFragment = 8;     // [bytes]; room for Fast DDS's list links
constexpr std::size_t kStatisticsSize = 56;   // [bytes], as Fast DDS writes it
constexpr std::size_t kLivelinessSize = 24;   // [bytes]: encapsulation, GUID prefix, kind, length
constexpr std::size_t kMaxMinorParts = 1024;  // maximum strings of a partition, and properties

enum Parameter : std::uint16_t {
  kSentinel = 0x01,
  kLeaseDuration = 0x02,
  kTopicName = 0x05,
  kTypeName = 0x07,
  kProtocolVersion = 0x15,
  kVendor = 0x16,
  kReliability = 0x1a,
  kDurability = 0x1d,
  kPartition = 0x29,
  kUserData = 0x2c,
  kGroupData = 0x2d,
  kTopicData = 0x2e,
  kUnicastLocator = 0x2f,
  kMulticastLocator = 0x30,
  kDefaultUnicastLocator = 0x31,
  kMetatrafficUnicastLocator = 0x32,
  kMetatrafficMulticastLocator = 0x33,
  kDefaultMulticastLocator = 0x48,
  kParticipantGuid = 0x50,
  kBuiltinEndpoints = 0x58,
  kProperties = 0x59,
  kEndpointGuid = 0x5a,
  kEntityName = 0x62,
  kKeyHash = 0x70,
  kStatusInfo = 0x71,
  kDataRepresentation = 0x73,
  kIdentityToken = 0x1001,
  kPermissionsToken = 0x1002,
  kIdentityStatusToken = 0x1006,
};

// --- parameter lists ---

// Skips a length and that many bytes with padding; false if they extend past the value.
bool skip_string(Span value, bool little, std::size_t& at) {
  if (value.size() - at < 4) return false;
  const std::size_t size = u32(value.data() + at, little);
  if (size > value.size() - at - 4) return false;
  at = std::min(value.size(), at + 4 + ((size + 3) & ~std::size_t{3}));
  return true;
}

// Skips a count and, for each element, `parts` strings or octet sequences.
bool skip_list(Span value, bool little, std::size_t parts, std::size_t& at) {
  if (value.size() - at < 4) return false;
  const std::size_t count = u32(value.data() + at, little);
  if (count > kMaxMinorParts) return false;
  at += 4;
  for (std::size_t i = 0; i < count * parts; ++i)
    if (!skip_string(value, little, at)) return false;
  return true;
}

bool is_list_of_strings(Span value, bool little, std::size_t parts) {
  std::size_t at = 0;
  return skip_list(value, little, parts, at);
}

// Skips a DDS Security token: class id, string properties, binary properties.
bool skip_data_holder(Span value, bool little, std::size_t& at) {
  return skip_string(value, little, at) && skip_list(value, little, 2, at) &&
         skip_list(value, little, 2, at);
}

bool is_data_holder(Span value, bool little) {
  std::size_t at = 0;
  return skip_data_holder(value, little, at);
}

bool is_one_string(Span value, bool little) {
  std::size_t at = 0;
  return skip_string(value, little, at);
}

bool is_list_of_shorts(Span value, bool little) {
  return value.size() >= 4 && u32(value.data(), little) <= (value.size() - 4) / 2;
}

// Whether a parameter that Fast DDS reads from an announcement has a valid length.
bool is_parameter(std::uint16_t id, Span value, bool little) {
  switch (id) {
    case kTopicName:
    case kTypeName:
    case kEntityName:
    case kUserData:
    case kGroupData:
    case kTopicData:
      return is_one_string(value, little);
    case kPartition:
      return is_list_of_strings(value, little, 1);
    case kProperties:
      return is_list_of_strings(value, little, 2);
    case kIdentityToken:
    case kPermissionsToken:
    case kIdentityStatusToken:
      return is_data_holder(value, little);
    case kDataRepresentation:
      return is_list_of_shorts(value, little);
    case kUnicastLocator:
    case kMulticastLocator:
    case kDefaultUnicastLocator:
    case kMetatrafficUnicastLocator:
    case kMetatrafficMulticastLocator:
    case kDefaultMulticastLocator:
      return value.size() >= 24;
    case kParticipantGuid:
    case kEndpointGuid:
    case kKeyHash:
      return value.size() >= 16;
    case kReliability:
      return value.size() >= 12;
    case kLeaseDuration:
      return value.size() >= 8;
    case kBuiltinEndpoints:
    case kDurability:
      return value.size() >= 4;
    case kProtocolVersion:
    case kVendor:
      return value.size() >= 2;
    default:
      return true;
  }
}

bool any_parameter(std::uint16_t, Span, bool) { return true; }

// Size of a parameter list including its sentinel [bytes]; 0 if it extends past `bytes` or a value
// is invalid.
template <class IsParameter>
std::size_t list_size(Span bytes, bool little, IsParameter is_parameter_of_it) {
  for (std::size_t at = 0; bytes.size() - at >= 4;) {
    const std::uint16_t id = u16(bytes.data() + at, little);
    const std::size_t size = u16(bytes.data() + at + 2, little);
    at += 4;
    if (id == kSentinel) return at;
    const std::size_t padded = (size + 3) & ~std::size_t{3};
    if (padded > bytes.size() - at) return 0;
    if (!is_parameter_of_it(id, bytes.subspan(at, size), little)) return 0;
    at += padded;
  }
  return 0;
}

// --- data ---

// Secure discovery uses the same ids prefixed with 0xff and has other contents, so it is excluded.
bool announces(std::uint32_t writer, std::uint32_t reader) {
  return writer == kSpdpWriter || writer == kSedpPublicationsWriter ||
         writer == kSedpSubscriptionsWriter || reader == kSpdpReader ||
         reader == kSedpPublicationsReader || reader == kSedpSubscriptionsReader;
}

Drop check_announcement(Span payload) {
  const bool is_list =
      payload.size() >= 4 && payload[0] == 0 && (payload[1] == 2 || payload[1] == 3);
  if (!is_list) return Drop::kDiscovery;
  const bool whole = list_size(payload.subspan(4), payload[1] == 3, is_parameter) > 0;
  return whole ? Drop::kNone : Drop::kDiscovery;
}

bool authenticates(std::uint32_t writer, std::uint32_t reader) {
  return writer == kStatelessWriter || reader == kStatelessReader;
}

// Authentication or key exchange. Fast DDS also reads unprotected messages of the latter.
bool is_of_security(std::uint32_t writer, std::uint32_t reader) {
  return authenticates(writer, reader) || writer == kVolatileSecureWriter ||
         reader == kVolatileSecureReader;
}

// Checks a ParticipantGenericMessage: two identities, three GUIDs, class id, tokens. Fast DDS 2.9.1
// allocates as many tokens as the message claims (CVE-2025-62603).
Drop check_security_message(Span payload) {
  constexpr std::size_t kEncapsulation = 4, kFixed = 96, kLeastHolder = 12;
  if (payload.size() < kEncapsulation + kFixed || payload[0] != 0 || payload[1] > 1)
    return Drop::kSecurity;
  const bool little = payload[1] == 1;
  const Span message = payload.subspan(kEncapsulation);
  std::size_t at = kFixed;
  if (!skip_string(message, little, at) || message.size() - at < 4) return Drop::kSecurity;
  const std::size_t count = u32(message.data() + at, little);
  at += 4;
  if (count > (message.size() - at) / kLeastHolder) return Drop::kSecurity;
  for (std::size_t i = 0; i < count; ++i)
    if (!skip_data_holder(message, little, at)) return Drop::kSecurity;
  return Drop::kNone;
}

Drop check_payload(std::uint32_t writer, std::uint32_t reader, Span payload) {
  if (announces(writer, reader)) return check_announcement(payload);
  if (is_of_security(writer, reader)) return check_security_message(payload);
  const bool of_liveliness = writer == kLivelinessWriter || reader == kLivelinessReader;
  if (of_liveliness && payload.size() < kLivelinessSize) return Drop::kDiscovery;
  return Drop::kNone;
}

// Offset of the payload after the inline QoS; 0 if the inline QoS extends past the body. `fixed`:
// size of the fields before it in this protocol version [bytes]; octetsToInlineQos counts those
// after the first four.
std::size_t payload_at(const Submessage& data, std::size_t fixed) {
  constexpr std::uint8_t kInlineQos = 2;
  const std::size_t begin = std::size_t{4} + data.u16(2);
  if (begin < fixed || begin > data.body.size()) return 0;
  if ((data.flags & kInlineQos) == 0) return begin;
  const std::size_t size = list_size(data.body.subspan(begin), data.little(), any_parameter);
  return size == 0 ? 0 : begin + size;
}

Drop check_data(const Submessage& data) {
  constexpr std::size_t kFixed = 20;
  constexpr std::uint8_t kHasData = 4, kHasKey = 8;
  if (data.body.size() < kFixed || data.sequence_number(12) <= 0) return Drop::kSubmessage;
  const bool has_data = (data.flags & kHasData) != 0, has_key = (data.flags & kHasKey) != 0;
  if (has_data && has_key) return Drop::kSubmessage;
  const std::size_t begin = payload_at(data, kFixed);
  if (begin == 0) return Drop::kInlineQos;
  if (!has_data) return Drop::kNone;
  const Span payload = data.body.subspan(begin);
  if (payload.empty()) return Drop::kSubmessage;
  return check_payload(data.entity(8), data.entity(4), payload);
}

struct Fragments {
  std::uint64_t first, count, size, sample_size;

  [[nodiscard]] std::uint64_t of_sample() const { return (sample_size + size - 1) / size; }
  [[nodiscard]] std::uint64_t bytes() const {
    return std::min(first - 1 + count, of_sample()) == of_sample()
               ? sample_size - (first - 1) * size
               : count * size;
  }
  // Fast DDS writes a four-byte link, aligned to four bytes, into each missing fragment.
  [[nodiscard]] bool hold_list() const {
    const std::uint64_t last = ((of_sample() - 1) * size + 3) & ~std::uint64_t{3};
    return last + 4 <= ((sample_size + 3) & ~std::uint64_t{3});
  }
  [[nodiscard]] bool fit() const {
    return first >= 1 && count >= 1 && size >= kLeastFragment && sample_size >= 1 &&
           first - 1 + count <= of_sample() && hold_list();
  }
};

Drop check_data_frag(const Submessage& data, const GuardLimits& limits) {
  constexpr std::size_t kFixed = 32;
  if (data.body.size() < kFixed || data.sequence_number(12) <= 0) return Drop::kSubmessage;
  const std::size_t begin = payload_at(data, kFixed);
  if (begin == 0) return Drop::kInlineQos;
  const Fragments fragments{data.u32(20), data.u16(24), data.u16(26), data.u32(28)};
  if (!fragments.fit() || data.body.size() - begin < fragments.bytes()) return Drop::kFragment;
  if (is_of_security(data.entity(8), data.entity(4))) return Drop::kSecurity;
  const bool announced = announces(data.entity(8), data.entity(4));
  const auto limit = announced ? limits.discovery_size : limits.sample_size;
  return fragments.sample_size > limit ? Drop::kSampleSize : Drop::kNone;
}

// --- reliability protocol ---

// Whether there is a valid number set at `at`, with a base of `base` bytes, and `after` more bytes.
bool has_set(const Submessage& submessage, std::size_t at, std::size_t base, std::size_t after) {
  if (submessage.body.size() < at + base + 4) return false;
  const std::size_t bits = submessage.u32(at + base);
  return bits <= kMaxBits && submessage.body.size() >= at + base + 4 + (bits + 31) / 32 * 4 + after;
}

Drop check_acknack(const Submessage& acknack) {
  if (!has_set(acknack, 8, 8, 4)) return Drop::kNumberSet;
  return acknack.sequence_number(8) < 0 ? Drop::kNumberSet : Drop::kNone;
}

Drop check_gap(const Submessage& gap) {
  if (!has_set(gap, 16, 8, 0)) return Drop::kNumberSet;
  const std::int64_t first = gap.sequence_number(8), base = gap.sequence_number(16);
  return first <= 0 || base < first ? Drop::kNumberSet : Drop::kNone;
}

Drop check_heartbeat(const Submessage& heartbeat) {
  if (heartbeat.body.size() < 28) return Drop::kSubmessage;
  const std::int64_t first = heartbeat.sequence_number(8), last = heartbeat.sequence_number(16);
  return first <= 0 || last < first - 1 ? Drop::kNumberSet : Drop::kNone;
}

Drop check_heartbeat_frag(const Submessage& heartbeat) {
  if (heartbeat.body.size() < 24) return Drop::kSubmessage;
  const bool counts = heartbeat.sequence_number(8) > 0 && heartbeat.u32(16) > 0;
  return counts ? Drop::kNone : Drop::kNumberSet;
}

Drop check_nack_frag(const Submessage& nack) {
  if (!has_set(nack, 16, 4, 4)) return Drop::kNumberSet;
  return nack.sequence_number(8) <= 0 || nack.u32(16) == 0 ? Drop::kNumberSet : Drop::kNone;
}

// --- other submessages and protection ---

Drop at_least(const Submessage& submessage, std::size_t size) {
  return submessage.body.size() < size ? Drop::kSubmessage : Drop::kNone;
}

Drop check_timestamp(const Submessage& timestamp) {
  constexpr std::uint8_t kInvalidate = 2;
  return at_least(timestamp, (timestamp.flags & kInvalidate) != 0 ? 0 : 8);
}

// For eProsima's messages. Fast DDS terminates the process if this submessage is not the last one.
Drop check_statistics(const Submessage& statistics) {
  const bool as_written = statistics.body.size() == kStatisticsSize && statistics.last;
  return as_written ? Drop::kNone : Drop::kStatistics;
}

// Whether the submessage may be unprotected in a domain that protects every datagram. Encrypted
// submessages pass: they belong to the key exchange, or Fast DDS cannot decrypt them.
bool may_be_unprotected(const Submessage& submessage) {
  switch (submessage.id) {
    case kData: {
      const std::uint32_t writer = submessage.entity(8), reader = submessage.entity(4);
      if (writer == kSpdpWriter) return reader == kSpdpReader || reader == kUnknownReader;
      return writer == kStatelessWriter && (reader == kStatelessReader || reader == kUnknownReader);
    }
    case kDataFrag:
    case kAckNack:
    case kHeartbeat:
    case kGap:
    case kNackFrag:
    case kHeartbeatFrag:
      return false;
    default:
      return true;
  }
}

// Whether the submessage announces that a participant has left: by a key without data, or by its
// status.
bool says_goodbye(const Submessage& submessage) {
  constexpr std::uint8_t kInlineQos = 2, kHasData = 4, kGone = 3;  // disposed, unregistered
  if (submessage.id != kData || submessage.entity(8) != kSpdpWriter) return false;
  if ((submessage.flags & kHasData) == 0) return true;
  if ((submessage.flags & kInlineQos) == 0) return false;
  bool gone = false;
  const auto look = [&gone](std::uint16_t id, Span value, bool) {
    gone = gone || (id == kStatusInfo && value.size() >= 4 && (value[3] & kGone) != 0);
    return true;
  };
  (void)list_size(submessage.body.subspan(std::size_t{4} + submessage.u16(2)), submessage.little(),
                  look);
  return gone;
}

Drop check_exposed(const Submessage& submessage) {
  if (!may_be_unprotected(submessage)) return Drop::kUnsecured;
  return says_goodbye(submessage) ? Drop::kGoodbye : Drop::kNone;
}

Drop check(const Submessage& submessage, bool of_eprosima, const GuardLimits& limits) {
  switch (submessage.id) {
    case kData:
      return check_data(submessage);
    case kDataFrag:
      return check_data_frag(submessage, limits);
    case kAckNack:
      return check_acknack(submessage);
    case kHeartbeat:
      return check_heartbeat(submessage);
    case kGap:
      return check_gap(submessage);
    case kNackFrag:
      return check_nack_frag(submessage);
    case kHeartbeatFrag:
      return check_heartbeat_frag(submessage);
    case kInfoTimestamp:
      return check_timestamp(submessage);
    case kInfoDestination:
      return at_least(submessage, 12);
    case kInfoSource:
      return at_least(submessage, 20);
    case kStatistics:
      return of_eprosima ? check_statistics(submessage) : Drop::kNone;
    default:
      return Drop::kNone;
  }
}

bool has_header(Span datagram) {
  return datagram.size() >= kHeaderSize && std::memcmp(datagram.data(), "RTPS", 4) == 0 &&
         datagram[4] == kVersion;
}

}  // namespace

const char* name(Drop drop) {
  switch (drop) {
    case Drop::kNone:
      return "none";
    case Drop::kHeader:
      return "header";
    case Drop::kSubmessage:
      return "submessage";
    case Drop::kInlineQos:
      return "inline QoS";
    case Drop::kFragment:
      return "fragment";
    case Drop::kSampleSize:
      return "sample size";
    case Drop::kNumberSet:
      return "number set";
    case Drop::kDiscovery:
      return "discovery data";
    case Drop::kStatistics:
      return "statistics";
    case Drop::kAnnouncement:
      return "too many announcements";
    case Drop::kSequence:
      return "sequence number";
    case Drop::kSecurity:
      return "security message";
    case Drop::kUnsecured:
      return "unsecured";
    case Drop::kGoodbye:
      return "goodbye";
  }
  return "";
}

Drop check_datagram(std::span<const std::uint8_t> datagram, const GuardLimits& limits) {
  if (!has_header(datagram)) return Drop::kHeader;
  const bool of_eprosima = datagram[6] == 0x01 && datagram[7] == 0x0f;
  const bool exposed = limits.all_protected && !is_protected(datagram);
  Submessage submessage;
  for (Submessages all{datagram}; !all.at_end();) {
    if (!all.next(submessage)) return Drop::kSubmessage;
    if (const Drop drop = check(submessage, of_eprosima, limits); drop != Drop::kNone) return drop;
    if (!exposed) continue;
    if (const Drop drop = check_exposed(submessage); drop != Drop::kNone) return drop;
  }
  return Drop::kNone;
}

bool announces_participant(std::span<const std::uint8_t> datagram) {
  Submessage submessage;
  for (Submessages all{datagram}; !all.at_end() && all.next(submessage);)
    if (submessage.id == kData && submessage.entity(8) == kSpdpWriter) return true;
  return false;
}

bool is_protected(std::span<const std::uint8_t> datagram) {
  return datagram.size() > kHeaderSize && datagram[kHeaderSize] == kSecureRtpsPrefix;
}

}  // namespace tandem::runtime
