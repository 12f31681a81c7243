// SPDX-License-Identifier: Apache-2.0
// The records of an MCAP file (https://mcap.dev/spec), as bytes. Integers are little endian.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::mcap {

using Bytes = std::vector<std::uint8_t>;
using View = std::span<const std::uint8_t>;

/// First and last bytes of a file.
inline constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
inline constexpr std::size_t kHead = 9;         ///< [bytes] opcode and length before each record
inline constexpr std::size_t kFooterSize = 20;  ///< [bytes] content of the footer

/// Kinds of records. Others may come (0x10 to 0x7f) or are private (from 0x80); 0 is invalid.
enum class Op : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd,
};

struct Schema {
  std::uint16_t id = 0;        ///< from 1
  std::string name, encoding;  ///< "geometry_msgs/msg/Twist", "ros2msg"; encoding "": unknown
  std::string text;
  bool operator==(const Schema&) const = default;
};

struct Channel {
  std::uint16_t id = 0, schema = 0;  ///< schema 0: none
  std::string topic, encoding;       ///< "/cmd_vel", "cdr"
  std::map<std::string, std::string> metadata;
  bool operator==(const Channel&) const = default;
};

/// A chunk's fields before its records. Times [ns].
struct Chunk {
  std::uint64_t start = 0, end = 0;
  std::uint64_t size = 0;  ///< of the records when they are decompressed [bytes]
  std::uint32_t crc = 0;   ///< of the decompressed records; 0: none
  std::string compression;
  std::uint64_t packed_size = 0;  ///< of the records as stored [bytes]
};

/// A message's fields before its data. `time`: of its reception [ns since 1970].
struct Message {
  std::uint16_t channel = 0;
  std::uint64_t time = 0;
};

/// A field runs past the end of its record.
struct ShortRecord : std::runtime_error {
  ShortRecord() : std::runtime_error{"a field is longer than its record"} {}
};

/// CRC-32 as in zlib. `sum`: that of the bytes before, to go on with.
[[nodiscard]] std::uint32_t crc32(View bytes, std::uint32_t sum = 0);

/// Appends fields and whole records to bytes.
class Output {
 public:
  explicit Output(Bytes& bytes) : bytes_{bytes} {}

  void u8(std::uint8_t value) { bytes_.push_back(value); }
  void u16(std::uint16_t value) { put(value, 2); }
  void u32(std::uint32_t value) { put(value, 4); }
  void u64(std::uint64_t value) { put(value, 8); }
  void raw(View bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void text(std::string_view text);
  void map(const std::map<std::string, std::string>& entries);

  void begin(Op op);  ///< of a record; records do not nest
  void end();

  void record(const Schema& schema);
  void record(const Channel& channel);

 private:
  void put(std::uint64_t value, int size);

  Bytes& bytes_;
  std::size_t start_ = 0;  // of the record's content
};

/// Takes fields from a record's content. Every function throws ShortRecord at its end.
class Input {
 public:
  explicit Input(View bytes) : bytes_{bytes} {}

  [[nodiscard]] View rest() const { return bytes_; }
  std::uint8_t u8() { return static_cast<std::uint8_t>(take(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(take(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(take(4)); }
  std::uint64_t u64() { return take(8); }
  View raw(std::uint64_t size);
  std::string text();
  std::map<std::string, std::string> map();

  Schema schema();
  Channel channel();
  Message message();
  Chunk chunk();  ///< leaves the packed records, or what there is of them, in rest()

 private:
  std::uint64_t take(std::size_t size);

  View bytes_;
};

}  // namespace tandem::mcap
