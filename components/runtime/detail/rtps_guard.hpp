// SPDX-License-Identifier: Apache-2.0
// Decides whether a datagram is safe for Fast DDS to parse. Private to runtime/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tandem::runtime {

/// Why a datagram is dropped.
enum class Drop {
  kNone,          ///< accepted
  kHeader,        ///< missing RTPS 2 header
  kSubmessage,    ///< a submessage that is truncated, too short for its kind or has invalid flags
  kInlineQos,     ///< inline QoS, or the data before it, extends past the submessage
  kFragment,      ///< inconsistent fragment numbers or sizes
  kSampleSize,    ///< a sample larger than GuardLimits::sample_size
  kNumberSet,     ///< an invalid set of sequence or fragment numbers
  kDiscovery,     ///< SPDP, SEDP or liveliness data inconsistent with their lengths
  kStatistics,    ///< a statistics submessage unlike those that Fast DDS writes
  kAnnouncement,  ///< announcement rate exceeded
  kSequence,      ///< a sequence number that leaps, or is far ahead of the reader
  kSecurity,      ///< a DDS Security message that is fragmented or inconsistent with its lengths
  kUnsecured,     ///< unprotected although governance protects all datagrams
  kGoodbye,       ///< an unprotected goodbye of a participant, likewise; anyone can forge it
};
inline constexpr std::size_t kDropKinds = 14;
/// The name of a kind for reports, such as "inline QoS".
[[nodiscard]] const char* name(Drop drop);

struct GuardLimits {
  std::uint32_t sample_size = std::uint32_t{64} << 20;    ///< maximum fragmented sample [bytes]
  std::uint32_t discovery_size = std::uint32_t{1} << 20;  ///< the same for discovery data [bytes]
  /// Whether the domain's governance protects every datagram. If so, an unprotected datagram may
  /// only announce or authenticate a participant, because Fast DDS 2.9.1 accepts forged goodbyes
  /// (CVE-2023-50257), heartbeats, gaps, and data of topics protected by submessage only.
  bool all_protected = false;
};

/// Checks the RTPS header, the length of every submessage and all contents that Fast DDS 2.9.1 uses
/// without validation. Unknown content passes: later minor versions, other vendors' submessages and
/// encrypted ones. Reads only inside the datagram and does not allocate.
[[nodiscard]] Drop check_datagram(std::span<const std::uint8_t> datagram,
                                  const GuardLimits& limits);

/// Whether a submessage announces a participant. The datagram must have passed check_datagram().
[[nodiscard]] bool announces_participant(std::span<const std::uint8_t> datagram);

/// Whether DDS Security protects the whole datagram, so that Fast DDS rejects any tampering.
[[nodiscard]] bool is_protected(std::span<const std::uint8_t> datagram);

}  // namespace tandem::runtime
