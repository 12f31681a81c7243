// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/rtps_payload.hpp"

#include <algorithm>

namespace tandem::runtime::rtps_message {
namespace {

constexpr std::size_t kMaxMinorParts = 1024;  // maximum strings of a partition, and properties

enum Parameter : std::uint16_t {
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
  kDataRepresentation = 0x73,
  kIdentityToken = 0x1001,
  kPermissionsToken = 0x1002,
  kIdentityStatusToken = 0x1006,
};

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

}  // namespace

std::size_t find_in_list(Span bytes, std::size_t at, bool little, std::uint16_t wanted) {
  constexpr std::uint16_t kSentinel = 0x01;
  while (at + 4 <= bytes.size()) {
    const std::uint16_t id = u16(bytes.data() + at, little);
    if (id == wanted) return at;
    at += 4;
    if (id == kSentinel) break;
    at += (u16(bytes.data() + at - 2, little) + std::size_t{3}) & ~std::size_t{3};
  }
  return bytes.size();
}

AnnouncedList announced_list(const Submessage& data) {
  constexpr std::uint8_t kInlineQos = 2, kHasData = 4;
  constexpr std::uint16_t kSentinel = 0x01;
  constexpr std::size_t kEncapsulation = 4;
  const AnnouncedList none{data.body.size(), true};
  if ((data.flags & kHasData) == 0 || data.body.size() < kEncapsulation) return none;
  std::size_t at = std::size_t{4} + data.u16(2);
  if ((data.flags & kInlineQos) != 0)
    at = find_in_list(data.body, at, data.little(), kSentinel) + 4;
  if (at + kEncapsulation > data.body.size()) return none;
  return {at + kEncapsulation, data.body[at + 1] == 3};
}

bool is_announcement(Span payload) {
  const bool is_list =
      payload.size() >= 4 && payload[0] == 0 && (payload[1] == 2 || payload[1] == 3);
  return is_list && list_size(payload.subspan(4), payload[1] == 3, is_parameter) > 0;
}

bool is_security_message(Span payload) {
  constexpr std::size_t kEncapsulation = 4, kFixed = 96, kLeastHolder = 12;
  if (payload.size() < kEncapsulation + kFixed || payload[0] != 0 || payload[1] > 1) return false;
  const bool little = payload[1] == 1;
  const Span message = payload.subspan(kEncapsulation);
  std::size_t at = kFixed;
  if (!skip_string(message, little, at) || message.size() - at < 4) return false;
  const std::size_t count = u32(message.data() + at, little);
  at += 4;
  if (count > (message.size() - at) / kLeastHolder) return false;
  for (std::size_t i = 0; i < count; ++i)
    if (!skip_data_holder(message, little, at)) return false;
  return true;
}

}  // namespace tandem::runtime::rtps_message
