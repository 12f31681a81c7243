// SPDX-License-Identifier: Apache-2.0
// Checks what DDS sends about itself: announcements, and messages of authentication and key
// exchange. Private to runtime/.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tandem/runtime/detail/rtps_message.hpp"

namespace tandem::runtime::rtps_message {

/// Size of a parameter list including its sentinel [bytes]; 0 if it extends past `bytes` or
/// `accepts(id, value, little)` rejects one of its parameters.
template <class Accepts>
std::size_t list_size(Span bytes, bool little, Accepts accepts) {
  constexpr std::uint16_t kSentinel = 0x01;
  for (std::size_t at = 0; bytes.size() - at >= 4;) {
    const std::uint16_t id = u16(bytes.data() + at, little);
    const std::size_t size = u16(bytes.data() + at + 2, little);
    at += 4;
    if (id == kSentinel) return at;
    const std::size_t padded = (size + 3) & ~std::size_t{3};
    if (padded > bytes.size() - at) return 0;
    if (!accepts(id, bytes.subspan(at, size), little)) return 0;
    at += padded;
  }
  return 0;
}

/// Offset of the parameter `wanted` in the list that begins at `at`; bytes.size() if it is missing.
[[nodiscard]] std::size_t find_in_list(Span bytes, std::size_t at, bool little,
                                       std::uint16_t wanted);

/// Where in the body of a DATA submessage the parameter list of an announcement begins, and its
/// byte order.
struct AnnouncedList {
  std::size_t at;  ///< the body's size if there is none
  bool little;
};
[[nodiscard]] AnnouncedList announced_list(const Submessage& data);

/// Whether data between these endpoints announce participants or endpoints. Secure discovery uses
/// the same ids prefixed with 0xff and has other contents, so it is excluded.
[[nodiscard]] inline bool announces(std::uint32_t writer, std::uint32_t reader) {
  return writer == kSpdpWriter || writer == kSedpPublicationsWriter ||
         writer == kSedpSubscriptionsWriter || reader == kSpdpReader ||
         reader == kSedpPublicationsReader || reader == kSedpSubscriptionsReader;
}

/// Whether data between these endpoints authenticate or exchange keys. Fast DDS also reads
/// unprotected messages of the latter.
[[nodiscard]] inline bool is_of_security(std::uint32_t writer, std::uint32_t reader) {
  return writer == kStatelessWriter || reader == kStatelessReader ||
         writer == kVolatileSecureWriter || reader == kVolatileSecureReader;
}

/// Whether the payload is a parameter list whose values have the lengths that Fast DDS relies on.
[[nodiscard]] bool is_announcement(Span payload);

/// Whether the payload is a whole ParticipantGenericMessage: two identities, three GUIDs, class id,
/// tokens. Fast DDS 2.9.1 allocates as many tokens as the message claims (CVE-2025-62603).
[[nodiscard]] bool is_security_message(Span payload);

}  // namespace tandem::runtime::rtps_message
