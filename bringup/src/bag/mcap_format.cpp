// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/mcap_format.hpp"

namespace tandem::mcap {
namespace {

constexpr std::size_t kSlices = 8;  // bytes that are looked up at once
using CrcTables = std::array<std::array<std::uint32_t, 256>, kSlices>;

// Table k: the effect of a byte with k bytes behind it.
constexpr CrcTables crc_tables() {
  constexpr std::uint32_t kPolynomial = 0xedb88320U;
  CrcTables tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t sum = i;
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1U) != 0 ? (sum >> 1U) ^ kPolynomial : sum >> 1U;
    tables[0][i] = sum;
  }
  for (std::size_t k = 1; k < kSlices; ++k)
    for (std::size_t i = 0; i < 256; ++i)
      tables[k][i] = tables[0][tables[k - 1][i] & 0xffU] ^ (tables[k - 1][i] >> 8U);
  return tables;
}

constexpr CrcTables kCrc = crc_tables();

}  // namespace

std::uint32_t crc32(View bytes, std::uint32_t sum) {
  sum = ~sum;
  for (; bytes.size() >= kSlices; bytes = bytes.subspan(kSlices)) {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < kSlices; ++i) {
      const std::uint32_t before = i < 4 ? sum >> 8U * i : 0;
      next ^= kCrc[kSlices - 1 - i][(bytes[i] ^ before) & 0xffU];
    }
    sum = next;
  }
  for (const std::uint8_t byte : bytes) sum = kCrc[0][(sum ^ byte) & 0xffU] ^ (sum >> 8U);
  return ~sum;
}

void Output::put(std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i, value >>= 8U) u8(static_cast<std::uint8_t>(value & 0xffU));
}

void Output::text(std::string_view text) {
  u32(static_cast<std::uint32_t>(text.size()));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
}

void Output::map(const std::map<std::string, std::string>& entries) {
  std::size_t size = 0;
  for (const auto& [key, value] : entries) size += 8 + key.size() + value.size();
  u32(static_cast<std::uint32_t>(size));
  for (const auto& [key, value] : entries) {
    text(key);
    text(value);
  }
}

void Output::begin(Op op) {
  u8(static_cast<std::uint8_t>(op));
  u64(0);  // replaced by end()
  start_ = bytes_.size();
}

void Output::end() {
  std::uint64_t size = bytes_.size() - start_;
  for (std::size_t i = start_ - 8; i < start_; ++i, size >>= 8U)
    bytes_[i] = static_cast<std::uint8_t>(size & 0xffU);
}

void Output::record(const Schema& schema) {
  begin(Op::kSchema);
  u16(schema.id);
  text(schema.name);
  text(schema.encoding);
  text(schema.text);
  end();
}

void Output::record(const Channel& channel) {
  begin(Op::kChannel);
  u16(channel.id);
  u16(channel.schema);
  text(channel.topic);
  text(channel.encoding);
  map(channel.metadata);
  end();
}

View Input::raw(std::uint64_t size) {
  if (size > bytes_.size()) throw ShortRecord{};
  const View taken = bytes_.first(static_cast<std::size_t>(size));
  bytes_ = bytes_.subspan(taken.size());
  return taken;
}

std::uint64_t Input::take(std::size_t size) {
  const View taken = raw(size);
  std::uint64_t value = 0;
  for (std::size_t i = size; i > 0; --i) value = value << 8U | taken[i - 1];
  return value;
}

std::string Input::text() {
  const View taken = raw(u32());
  return {taken.begin(), taken.end()};
}

std::map<std::string, std::string> Input::map() {
  std::map<std::string, std::string> entries;
  for (Input part{raw(u32())}; !part.rest().empty();) {
    const std::string key = part.text();
    entries[key] = part.text();
  }
  return entries;
}

Schema Input::schema() {
  Schema schema;
  schema.id = u16();
  schema.name = text();
  schema.encoding = text();
  schema.text = text();
  return schema;
}

Channel Input::channel() {
  Channel channel;
  channel.id = u16();
  channel.schema = u16();
  channel.topic = text();
  channel.encoding = text();
  channel.metadata = map();
  return channel;
}

Message Input::message() {
  Message message;
  message.channel = u16();
  (void)u32();  // sequence
  message.time = u64();
  (void)u64();  // of publication
  return message;
}

Chunk Input::chunk() {
  Chunk chunk;
  chunk.start = u64();
  chunk.end = u64();
  chunk.size = u64();
  chunk.crc = u32();
  chunk.compression = text();
  chunk.packed_size = u64();
  return chunk;
}

}  // namespace tandem::mcap
