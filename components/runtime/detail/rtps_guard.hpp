// SPDX-License-Identifier: Apache-2.0
// Decides whether a datagram is safe for Fast DDS to parse. Private to runtime/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tandem::runtime {

/// Why a datagram is dropped.
enum class Drop {
  kNone,          ///< it is not
  kHeader,        ///< no RTPS 2 header
  kSubmessage,    ///< a submessage that is cut, too short for its kind or of impossible flags
  kInlineQos,     ///< inline QoS or what lies before it leaves the submessage
  kFragment,      ///< fragment numbers or sizes that contradict each other
  kSampleSize,    ///< a sample above GuardLimits::sample_size
  kNumberSet,     ///< numbers of samples or fragments that no set may hold
  kDiscovery,     ///< SPDP, SEDP or liveliness data that contradict their lengths
  kStatistics,    ///< a statistics submessage that Fast DDS would not have written
  kAnnouncement,  ///< one of too many announcements
  kSequence,      ///< numbers far beyond what the reader holds
  kSecurity,      ///< a message of DDS Security that contradicts its lengths, or in fragments
  kUnsecured,     ///< unprotected, where all must be protected
  kGoodbye,       ///< of a participant, unprotected there: anybody can say it for anybody
};
inline constexpr std::size_t kDropKinds = 14;
/// "inline QoS", for reports.
[[nodiscard]] const char* name(Drop drop);

struct GuardLimits {
  std::uint32_t sample_size = std::uint32_t{64} << 20;    ///< [bytes] of a fragmented sample
  std::uint32_t discovery_size = std::uint32_t{1} << 20;  ///< [bytes] of fragmented discovery data
  /// Whether the domain's governance protects every datagram. Then an unprotected one may announce
  /// a participant or authenticate it, no more: Fast DDS 2.9.1 believes forged goodbyes
  /// (CVE-2023-50257), heartbeats and gaps, and data of topics that only their submessages protect.
  bool all_protected = false;
};

/// Checks the RTPS header, the length of every submessage and everything in them that Fast
/// DDS 2.9.1 follows without looking. What it does not know passes: later minor versions, other
/// vendors' submessages, encrypted ones. Reads nothing outside of the datagram, allocates nothing.
[[nodiscard]] Drop check_datagram(std::span<const std::uint8_t> datagram,
                                  const GuardLimits& limits);

/// Whether one of its submessages announces a participant. For datagrams that were checked.
[[nodiscard]] bool announces_participant(std::span<const std::uint8_t> datagram);

/// Whether DDS Security protects the datagram as a whole: Fast DDS drops it if a byte was changed.
[[nodiscard]] bool is_protected(std::span<const std::uint8_t> datagram);

}  // namespace tandem::runtime
