// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/server_restarts.hpp"

#include <array>

namespace tandem::runtime {
namespace {

using namespace rtps_message;

constexpr std::size_t kNumberAt = 2;  // of the server, in its prefix

// The server's farewell: its key without data, with the status `disposed, unregistered`.
std::vector<std::uint8_t> goodbye(const GuidPrefix& server, std::int64_t number) {
  constexpr std::uint16_t kParticipantGuid = 0x50, kKeyHash = 0x70;
  const auto u16 = [](std::uint16_t value) {
    return std::array{static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8)};
  };
  std::vector<std::uint8_t> bytes{'R', 'T', 'P', 'S', 2, 3, 0x01, 0x0f};
  const auto add = [&bytes](const auto& more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
  };
  const auto add_guid = [&](std::uint16_t parameter) {
    add(u16(parameter));
    add(u16(16));
    add(server);
    add(std::to_array<std::uint8_t>({0x00, 0x00, 0x01, 0xc1}));
  };
  const auto end_of_list = std::to_array<std::uint8_t>({1, 0, 0, 0});
  add(server);
  add(std::to_array<std::uint8_t>({kData, 0x0b, 0, 0}));       // little-endian, inline QoS, key
  add(std::to_array<std::uint8_t>({0, 0, 16, 0}));             // flags, bytes to the inline QoS
  add(std::to_array<std::uint8_t>({0x00, 0x01, 0x00, 0xc7}));  // kSpdpReader
  add(std::to_array<std::uint8_t>({0x00, 0x01, 0x00, 0xc2}));  // kSpdpWriter
  bytes.resize(bytes.size() + 8);
  put_sequence_number(&*bytes.end() - 8, number, true);
  add_guid(kKeyHash);
  add(std::to_array<std::uint8_t>({0x71, 0, 4, 0, 0, 0, 0, 3}));  // status
  add(end_of_list);
  add(std::to_array<std::uint8_t>({0, 3, 0, 0}));  // a parameter list, little-endian
  add_guid(kParticipantGuid);
  add(end_of_list);
  return bytes;  // a length of 0: the submessage extends to the end of the datagram
}

}  // namespace

bool is_server(const GuidPrefix& prefix) {
  constexpr GuidPrefix kServer{0x44, 0x53, 0x00, 0x5f, 0x45, 0x50,
                               0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};
  GuidPrefix numberless = prefix;
  numberless[kNumberAt] = kServer[kNumberAt];
  return numberless == kServer;
}

void ServerRestarts::sent(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kHeaderSize) return;
  GuidPrefix destination{};
  Submessage submessage;
  for (Submessages all{datagram}; !all.at_end() && all.next(submessage);) {
    if (submessage.id == kInfoDestination && submessage.body.size() >= kPrefixSize)
      destination = prefix_at(submessage.body.data());
    if (submessage.id != kAckNack || submessage.body.size() < 16) continue;
    if (submessage.entity(4) != kSpdpWriter || !is_server(destination)) continue;
    next_[destination] = submessage.sequence_number(8);
  }
}

std::vector<std::uint8_t> ServerRestarts::goodbye_before(std::span<const std::uint8_t> datagram) {
  if (next_.empty() || datagram.size() < kHeaderSize) return {};
  const auto known = next_.find(prefix_at(datagram.data() + kPrefixAt));
  if (known == next_.end()) return {};
  Submessage submessage;
  for (Submessages all{datagram}; !all.at_end() && all.next(submessage);) {
    if (submessage.id != kHeartbeat || submessage.body.size() < 28) continue;
    if (submessage.entity(4) != kSpdpWriter || submessage.sequence_number(16) + 1 >= known->second)
      continue;
    auto bytes = goodbye(known->first, known->second);
    next_.erase(known);
    return bytes;
  }
  return {};
}

}  // namespace tandem::runtime
