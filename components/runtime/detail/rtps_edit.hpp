// SPDX-License-Identifier: Apache-2.0
// Changes the submessages of a datagram in place. Private to runtime/.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "tandem/runtime/detail/rtps_message.hpp"

namespace tandem::runtime {

using GuidPrefix = std::array<std::uint8_t, rtps_message::kPrefixSize>;

inline GuidPrefix prefix_at(const std::uint8_t* p) {
  GuidPrefix prefix;
  std::memcpy(prefix.data(), p, prefix.size());
  return prefix;
}

inline std::uint64_t mixed(std::uint64_t value) {
  value ^= value >> 33;
  value *= 0xff51afd7ed558ccdULL;
  return value ^ value >> 33;
}

template <class T>
T bytes_at(const std::uint8_t* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

inline void put_u32(std::uint8_t* p, std::uint32_t value, bool little) {
  for (int i = 0; i < 4; ++i) p[little ? i : 3 - i] = static_cast<std::uint8_t>(value >> 8 * i);
}
inline void put_sequence_number(std::uint8_t* p, std::int64_t value, bool little) {
  put_u32(p, static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32), little);
  put_u32(p + 4, static_cast<std::uint32_t>(value), little);
}

/// The body of a submessage that was read from `datagram`.
inline std::uint8_t* bytes_of(std::span<std::uint8_t> datagram,
                              const rtps_message::Submessage& submessage) {
  return datagram.data() + (submessage.body.data() - datagram.data());
}

/// Removes the submessage of this body: readers skip ids that are not assigned.
inline void mark_removed(std::uint8_t* body) { body[-4] = 0x7f; }

/// Calls `keep(submessage, source prefix)` for each submessage and removes those for which it
/// returns false. Returns the number of removed ones.
template <class Keep>
int take_out(std::span<std::uint8_t> datagram, Keep keep) {
  GuidPrefix source = prefix_at(datagram.data() + rtps_message::kPrefixAt);
  rtps_message::Submessage submessage;
  int taken = 0;
  for (rtps_message::Submessages all{datagram}; !all.at_end() && all.next(submessage);) {
    if (submessage.id == rtps_message::kInfoSource) source = prefix_at(submessage.body.data() + 8);
    if (keep(submessage, source)) continue;
    mark_removed(bytes_of(datagram, submessage));
    ++taken;
  }
  return taken;
}

}  // namespace tandem::runtime
