// SPDX-License-Identifier: Apache-2.0
// Private to runtime/. In: the bytes of one datagram. Out: whether Fast DDS may parse them.
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
};
inline constexpr std::size_t kDropKinds = 11;
/// "inline QoS", for reports.
[[nodiscard]] const char* name(Drop drop);

struct GuardLimits {
  std::uint32_t sample_size = std::uint32_t{64} << 20;    ///< [bytes] of a fragmented sample
  std::uint32_t discovery_size = std::uint32_t{1} << 20;  ///< [bytes] of fragmented discovery data
};

/// Checks the RTPS header, the length of every submessage and everything in them that Fast
/// DDS 2.9.1 follows without looking. What it does not know passes: later minor versions, other
/// vendors' submessages, encrypted ones. Reads nothing outside of the datagram, allocates nothing.
[[nodiscard]] Drop check_datagram(std::span<const std::uint8_t> datagram,
                                  const GuardLimits& limits);

}  // namespace tandem::runtime
