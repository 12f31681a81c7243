// SPDX-License-Identifier: Apache-2.0
// Builds RTPS datagrams by hand, valid and invalid, and loads those in tests/runtime/datagrams.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/paths.hpp"

namespace tandem::test {

using Octets = std::vector<std::uint8_t>;
using Parameters = std::vector<std::pair<std::uint16_t, Octets>>;

template <class T>
void append(Octets& octets, T number, bool little) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    const std::size_t shift = 8 * (little ? i : sizeof(T) - 1 - i);
    octets.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(number) >> shift));
  }
}

inline void append_sequence_number(Octets& octets, std::int64_t number, bool little) {
  append(octets, static_cast<std::uint32_t>(static_cast<std::uint64_t>(number) >> 32), little);
  append(octets, static_cast<std::uint32_t>(number), little);
}

inline Octets parameter_list(const Parameters& parameters, bool little) {
  Octets octets;
  for (const auto& [id, value] : parameters) {
    append(octets, id, little);
    append(octets, static_cast<std::uint16_t>((value.size() + 3) / 4 * 4), little);
    octets.insert(octets.end(), value.begin(), value.end());
    octets.resize((octets.size() + 3) / 4 * 4);
  }
  append(octets, std::uint16_t{1}, little);
  append(octets, std::uint16_t{0}, little);
  return octets;
}

/// The fields of a DATA submessage before its payload.
struct Data {
  std::uint32_t reader = 0, writer = 0x00001203;  // a user's writer
  std::int64_t number = 1;
  int flags = 4;           // there is data
  int to_inline_qos = -1;  // -1: the correct value
  std::size_t extra = 0;   // bytes of a later version before the inline QoS
  Parameters inline_qos{};
};

struct Fragment {
  std::uint32_t first = 1;
  std::uint16_t count = 1, size = 1000;
  std::uint32_t sample = 1000;
  std::uint32_t reader = 0, writer = 0x00001203;
  std::int64_t number = 1;
  int to_inline_qos = -1;
  Parameters inline_qos{};
};

/// A datagram to which submessages are appended.
class Datagram {
 public:
  explicit Datagram(bool little = true) : little_{little} {}

  Datagram& vendor(std::uint16_t vendor) {
    octets_[6] = static_cast<std::uint8_t>(vendor >> 8);
    octets_[7] = static_cast<std::uint8_t>(vendor);
    return *this;
  }
  Datagram& prefix(const Octets& prefix) {
    std::copy_n(prefix.begin(), 12, octets_.begin() + 8);
    return *this;
  }

  Datagram& add(std::uint8_t id, int flags, const Octets& body) {
    last_ = octets_.size();
    octets_.push_back(id);
    octets_.push_back(static_cast<std::uint8_t>(flags | (little_ ? 1 : 0)));
    append(octets_, static_cast<std::uint16_t>(body.size()), little_);
    octets_.insert(octets_.end(), body.begin(), body.end());
    octets_.resize((octets_.size() + 3) / 4 * 4);
    return *this;
  }
  Datagram& without_last_length() {
    octets_[last_ + 2] = octets_[last_ + 3] = 0;
    return *this;
  }

  Datagram& add_data(const Data& data, const Octets& payload) {
    Octets body =
        start_of(data.reader, data.writer, data.number, data.to_inline_qos, 16 + data.extra);
    body.insert(body.end(), data.extra, 0);
    return add_with(0x15, data.flags, body, data.inline_qos, payload);
  }
  Datagram& add_data_frag(const Fragment& fragment, const Octets& payload) {
    Octets body =
        start_of(fragment.reader, fragment.writer, fragment.number, fragment.to_inline_qos, 28);
    append(body, fragment.first, little_);
    append(body, fragment.count, little_);
    append(body, fragment.size, little_);
    append(body, fragment.sample, little_);
    return add_with(0x16, 0, body, fragment.inline_qos, payload);
  }
  /// A parameter list with its encapsulation header.
  [[nodiscard]] static Octets list_payload(const Parameters& parameters, bool little) {
    Octets payload{0, static_cast<std::uint8_t>(little ? 3 : 2), 0, 0};
    const Octets list = parameter_list(parameters, little);
    payload.insert(payload.end(), list.begin(), list.end());
    return payload;
  }
  Datagram& add_announcement(std::uint32_t writer, const Parameters& parameters) {
    return add_data({.writer = writer}, list_payload(parameters, little_));
  }

  Datagram& add_heartbeat(std::int64_t first, std::int64_t last, std::uint32_t count = 1,
                          std::uint32_t reader = 0, std::uint32_t writer = 0x00001203) {
    Octets body = entities(reader, writer);
    append_sequence_number(body, first, little_);
    append_sequence_number(body, last, little_);
    append(body, count, little_);
    return add(0x07, 0, body);
  }
  Datagram& add_acknack(std::int64_t base, std::uint32_t bits, int words = -1,
                        std::uint32_t reader = 0x00001204, std::uint32_t writer = 0x00001203) {
    Octets body = entities(reader, writer);
    append_sequence_number(body, base, little_);
    append_bits(body, bits, words);
    append(body, std::uint32_t{1}, little_);
    return add(0x06, 0, body);
  }
  Datagram& add_nack_frag(std::int64_t number, std::uint32_t base, std::uint32_t bits) {
    Octets body = entities(0x00001204, 0x00001203);
    append_sequence_number(body, number, little_);
    append(body, base, little_);
    append_bits(body, bits, -1);
    append(body, std::uint32_t{1}, little_);
    return add(0x12, 0, body);
  }
  Datagram& add_gap(std::int64_t first, std::int64_t base, std::uint32_t bits,
                    std::uint32_t reader = 0, std::uint32_t writer = 0x00001203) {
    Octets body = entities(reader, writer);
    append_sequence_number(body, first, little_);
    append_sequence_number(body, base, little_);
    append_bits(body, bits, -1);
    return add(0x08, 0, body);
  }
  Datagram& add_destination(const Octets& prefix) { return add(0x0e, 0, prefix); }

  [[nodiscard]] const Octets& octets() const { return octets_; }

 private:
  static void append_entity(Octets& octets, std::uint32_t entity) { append(octets, entity, false); }

  [[nodiscard]] static Octets entities(std::uint32_t reader, std::uint32_t writer) {
    Octets octets;
    append_entity(octets, reader);
    append_entity(octets, writer);
    return octets;
  }
  [[nodiscard]] Octets start_of(std::uint32_t reader, std::uint32_t writer, std::int64_t number,
                                int to_inline_qos, std::size_t usual) const {
    Octets octets{0, 0};
    const auto distance = to_inline_qos < 0 ? usual : static_cast<std::size_t>(to_inline_qos);
    append(octets, static_cast<std::uint16_t>(distance), little_);
    append_entity(octets, reader);
    append_entity(octets, writer);
    append_sequence_number(octets, number, little_);
    return octets;
  }
  // As many bits as the set says, in as many words as that takes or as are named.
  void append_bits(Octets& octets, std::uint32_t bits, int words) const {
    append(octets, bits, little_);
    const auto usual = static_cast<std::size_t>(std::min(bits, 256U) + 31) / 32 * 4;
    octets.resize(octets.size() + (words < 0 ? usual : static_cast<std::size_t>(words) * 4), 0xff);
  }
  Datagram& add_with(std::uint8_t id, int flags, Octets body, const Parameters& inline_qos,
                     const Octets& payload) {
    if (!inline_qos.empty()) {
      const Octets list = parameter_list(inline_qos, little_);
      body.insert(body.end(), list.begin(), list.end());
      flags |= 2;
    }
    body.insert(body.end(), payload.begin(), payload.end());
    return add(id, flags, body);
  }

  bool little_;
  std::size_t last_ = 0;
  static constexpr std::array<std::uint8_t, 20> kHeader{'R', 'T', 'P', 'S', 2, 3, 1, 0x10, 1,  2,
                                                        3,   4,   5,   6,   7, 8, 9, 10,   11, 12};
  Octets octets_ = Octets(kHeader.begin(), kHeader.end());
};

/// The files of a folder of tests/runtime/datagrams, sorted by name.
inline std::vector<std::filesystem::path> datagram_files(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  const std::string path = source_path("tests/runtime/datagrams/" + folder);
  for (const auto& entry : std::filesystem::directory_iterator{path}) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

inline Octets read(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{in}, {}};
}

/// Positions where a well-formed datagram may be cut: after each submessage, with or without
/// padding.
inline std::set<std::size_t> submessage_ends(const Octets& octets) {
  std::set<std::size_t> ends;
  for (std::size_t at = 20; at + 4 <= octets.size();) {
    const bool little = (octets[at + 1] & 1) != 0;
    const std::size_t size =
        little ? octets[at + 2] | octets[at + 3] << 8 : octets[at + 2] << 8 | octets[at + 3];
    for (std::size_t end = at + 4 + size; end <= at + 4 + (size + 3) / 4 * 4; ++end)
      ends.insert(end);
    at += 4 + (size + 3) / 4 * 4;
  }
  return ends;
}

}  // namespace tandem::test
