// SPDX-License-Identifier: Apache-2.0
// Reads the submessages of an RTPS datagram (OMG RTPS 2.5, chapter 9). Private to runtime/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tandem::runtime::rtps_message {

using Span = std::span<const std::uint8_t>;

inline constexpr std::size_t kHeaderSize = 20;  // "RTPS", version, vendor, GUID prefix
inline constexpr std::size_t kPrefixAt = 8;
inline constexpr std::size_t kPrefixSize = 12;

enum Id : std::uint8_t {
  kPad = 0x01,
  kAckNack = 0x06,
  kHeartbeat = 0x07,
  kGap = 0x08,
  kInfoTimestamp = 0x09,
  kInfoSource = 0x0c,
  kInfoReplyIp4 = 0x0d,
  kInfoDestination = 0x0e,
  kInfoReply = 0x0f,
  kNackFrag = 0x12,
  kHeartbeatFrag = 0x13,
  kData = 0x15,
  kDataFrag = 0x16,
  kSecurePrefix = 0x31,      // before an encrypted or signed submessage
  kSecureRtpsPrefix = 0x33,  // before the rest of an encrypted or signed datagram
  kStatistics = 0x80,        // eProsima's extension
};

/// Well-known entity ids, read as big-endian numbers.
enum Entity : std::uint32_t {
  kUnknownReader = 0x00000000,
  kSpdpWriter = 0x000100c2,
  kSpdpReader = 0x000100c7,
  kSedpPublicationsWriter = 0x000003c2,
  kSedpPublicationsReader = 0x000003c7,
  kSedpSubscriptionsWriter = 0x000004c2,
  kSedpSubscriptionsReader = 0x000004c7,
  kLivelinessWriter = 0x000200c2,
  kLivelinessReader = 0x000200c7,
  kStatelessWriter = 0x000201c3,  // authentication, unprotected
  kStatelessReader = 0x000201c4,
  kVolatileSecureWriter = 0xff0202c3,  // key exchange, protected
  kVolatileSecureReader = 0xff0202c4,
};

/// Reads numbers in the submessage's byte order. Does not check bounds.
template <bool little>
struct Number {
  static std::uint16_t u16(const std::uint8_t* p) {
    return static_cast<std::uint16_t>(little ? p[0] | p[1] << 8 : p[0] << 8 | p[1]);
  }
};
inline std::uint16_t u16(const std::uint8_t* p, bool little) {
  return little ? Number<true>::u16(p) : Number<false>::u16(p);
}
inline std::uint32_t u32(const std::uint8_t* p, bool little) {
  const std::uint32_t first = u16(p, little), second = u16(p + 2, little);
  return little ? first | second << 16 : first << 16 | second;
}
/// Reads a sequence number; the high half comes first in either byte order.
inline std::int64_t sequence_number(const std::uint8_t* p, bool little) {
  return static_cast<std::int64_t>(std::uint64_t{u32(p, little)} << 32 | u32(p + 4, little));
}
inline std::uint32_t entity(const std::uint8_t* p) { return u32(p, false); }

struct Submessage {
  std::uint8_t id, flags;
  Span body;  ///< without the submessage header
  bool last;  ///< extends to the end of the datagram

  [[nodiscard]] bool little() const { return (flags & 1) != 0; }
  [[nodiscard]] std::uint16_t u16(std::size_t at) const {
    return rtps_message::u16(body.data() + at, little());
  }
  [[nodiscard]] std::uint32_t u32(std::size_t at) const {
    return rtps_message::u32(body.data() + at, little());
  }
  [[nodiscard]] std::int64_t sequence_number(std::size_t at) const {
    return rtps_message::sequence_number(body.data() + at, little());
  }
  [[nodiscard]] std::uint32_t entity(std::size_t at) const {
    return rtps_message::entity(body.data() + at);
  }
};

/// Iterates over the submessages of a datagram.
class Submessages {
 public:
  explicit Submessages(Span datagram) : datagram_{datagram}, at_{kHeaderSize} {}

  [[nodiscard]] bool at_end() const { return at_ >= datagram_.size(); }

  /// Reads the next submessage; returns false if it is truncated.
  bool next(Submessage& submessage) {
    if (datagram_.size() - at_ < 4) return false;
    const std::uint8_t* header = datagram_.data() + at_;
    submessage.id = header[0];
    submessage.flags = header[1];
    const std::size_t rest = datagram_.size() - at_ - 4;
    std::size_t size = rtps_message::u16(header + 2, submessage.little());
    if (size > rest) return false;
    const bool may_be_empty = submessage.id == kPad || submessage.id == kInfoTimestamp;
    if (size == 0 && !may_be_empty) size = rest;  // 0 means up to the end of the datagram
    submessage.body = datagram_.subspan(at_ + 4, size);
    at_ += 4 + ((size + 3) & ~std::size_t{3});
    submessage.last = size == rest;
    return true;
  }

 private:
  Span datagram_;
  std::size_t at_;
};

}  // namespace tandem::runtime::rtps_message
