// SPDX-License-Identifier: Apache-2.0
// Writes an MCAP file of the profile "ros2", as rosbag2 does: chunks compressed with zstd, with an
// index of their messages, and a summary at the end.
#pragma once

#include <filesystem>
#include <map>
#include <utility>

#include "bringup/bag/bag_storage.hpp"
#include "bringup/bag/mcap_format.hpp"

namespace tandem {

/// Whether the topic's type is one that Tandem defines: its name and, if that is known, its hash.
[[nodiscard]] bool is_defined(const BagTopic& topic);

/// Topics whose type is_defined() get the definition as their schema; the others get a
/// schema without text, as rosbag2 does if it does not find the package.
class McapWriter : public BagFileWriter {
 public:
  /// Throws std::runtime_error if the file cannot be created.
  explicit McapWriter(const std::filesystem::path& file);
  ~McapWriter() override;
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  void add_topic(int id, const BagTopic& topic) override;
  /// Also flushes whenever 1 MiB of messages is waiting.
  void write(int topic, std::int64_t time, std::span<const std::uint8_t> bytes) override;
  void flush() override;
  void close(const std::string& metadata) override;

 private:
  using Index = std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>>;
  struct Span {
    void add(std::uint64_t time);
    std::uint64_t messages = 0, start = 0, end = 0;  // times [ns since 1970]
  };
  struct ChunkPlace {
    Span span;
    std::uint64_t offset = 0, length = 0, index_length = 0, size = 0, packed_size = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;  // by channel
  };

  std::uint16_t schema_of(const BagTopic& topic);
  void write_file(mcap::View bytes);
  ChunkPlace append_chunk(mcap::Bytes& out) const;
  void append_data_end(mcap::Bytes& out, const std::string& metadata);
  void append_summary(mcap::Bytes& out);
  void append_statistics(mcap::Output& record) const;
  void append_chunk_indexes(mcap::Output& record) const;

  std::string name_;
  int file_ = -1;
  std::uint64_t size_ = 0;  // of the file so far [bytes]
  std::uint32_t sum_ = 0;   // CRC of the file so far
  mcap::Bytes waiting_;     // records of the next chunk
  Span waiting_span_;
  Index waiting_index_;  // by channel: time and offset in waiting_
  Span all_;
  std::map<std::uint16_t, mcap::Channel> channels_;
  std::map<std::uint16_t, std::uint64_t> counts_;                        // messages by channel
  std::map<std::pair<std::string, std::string>, mcap::Schema> schemas_;  // by type and its hash
  std::vector<ChunkPlace> chunks_;
  std::uint64_t metadata_offset_ = 0, metadata_length_ = 0;
};

}  // namespace tandem
