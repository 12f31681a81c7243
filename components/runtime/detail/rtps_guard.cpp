// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/rtps_guard.hpp"

#include <algorithm>
#include <cstring>

#include "tandem/runtime/detail/rtps_message.hpp"
#include "tandem/runtime/detail/rtps_payload.hpp"

namespace tandem::runtime {
namespace {

using namespace rtps_message;

constexpr std::uint8_t kVersion = 2;
constexpr std::size_t kMaxBits = 256;        // maximum bits of a number set
constexpr std::size_t kLeastFragment = 8;    // [bytes]; room for Fast DDS's list links
constexpr std::size_t kStatisticsSize = 56;  // [bytes], as Fast DDS writes it
constexpr std::size_t kLivelinessSize = 24;  // [bytes]: encapsulation, GUID prefix, kind, length

// --- data ---

Drop check_payload(std::uint32_t writer, std::uint32_t reader, Span payload) {
  if (announces(writer, reader)) return is_announcement(payload) ? Drop::kNone : Drop::kDiscovery;
  if (is_of_security(writer, reader))
    return is_security_message(payload) ? Drop::kNone : Drop::kSecurity;
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
  const std::size_t size =
      list_size(data.body.subspan(begin), data.little(), [](auto...) { return true; });
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
  constexpr std::uint16_t kStatusInfo = 0x71;
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
