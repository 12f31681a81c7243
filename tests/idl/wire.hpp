// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <msgs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace tandem::runtime {

using Bytes = std::vector<uint8_t>;

#if __has_include(<fastdds/config.hpp>)  // Fast DDS 3
using Payload = eprosima::fastdds::rtps::SerializedPayload_t;
constexpr auto kXcdr1 = eprosima::fastdds::dds::DataRepresentationId_t::XCDR_DATA_REPRESENTATION;
#else
using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;
#endif

template <class M>
std::string type_name() {
#if __has_include(<fastdds/config.hpp>)
  return MessageType<M>::create()->get_name();
#else
  return MessageType<M>::create()->getName();
#endif
}

/// The message's bytes as a DataWriter sends them, including the encapsulation header. Alignment
/// gaps keep the buffer's previous content (`gap`).
template <class M>
Bytes serialize(M& message, uint8_t gap = 0) {
  const auto type = MessageType<M>::create();
#if __has_include(<fastdds/config.hpp>)
  Payload payload(type->calculate_serialized_size(&message, kXcdr1));
  std::fill_n(payload.data, payload.max_size, gap);
  const bool done = type->serialize(&message, payload, kXcdr1);
#else
  Payload payload(type->getSerializedSizeProvider(&message)());
  std::fill_n(payload.data, payload.max_size, gap);
  const bool done = type->serialize(&message, &payload);
#endif
  if (!done) throw std::runtime_error(std::string("cannot serialise ") + MessageType<M>::name);
  return Bytes(payload.data, payload.data + payload.length);
}

/// False if the bytes are not a valid M. The buffer has exactly their size, so that
/// AddressSanitizer detects overreads.
template <class M>
bool deserialize(const Bytes& bytes, M& message) {
  Payload payload(static_cast<uint32_t>(bytes.size()));
  payload.length = static_cast<uint32_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), payload.data);
#if __has_include(<fastdds/config.hpp>)
  return MessageType<M>::create()->deserialize(payload, &message);
#else
  return MessageType<M>::create()->deserialize(&payload, &message);
#endif
}

inline Bytes from_hex(const std::string& hex) {
  Bytes bytes;
  for (size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

/// The message's bytes in hexadecimal, with ".." in the gaps, whose content is undefined.
template <class M>
std::string to_hex(M& message) {
  constexpr const char* kDigits = "0123456789abcdef";
  const Bytes zeros = serialize(message, 0x00), ones = serialize(message, 0xff);
  std::string hex;
  for (size_t i = 0; i < zeros.size(); ++i) {
    const bool gap = zeros[i] != ones[i];
    hex += gap ? '.' : kDigits[zeros[i] >> 4];
    hex += gap ? '.' : kDigits[zeros[i] & 15];
  }
  return hex;
}

}  // namespace tandem::runtime
