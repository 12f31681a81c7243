// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/mcap_writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ros2_schema.hpp>
#include <stdexcept>
#include <type_hashes.hpp>

#include "bringup/bag/bag_qos.hpp"
#include "bringup/bag/zstd.hpp"
#include "tandem/version.hpp"

namespace tandem {
namespace {

using mcap::Op;

constexpr std::size_t kChunkSize = std::size_t{1} << 20U;  // [bytes]
constexpr const char* kZstd = "zstd";
constexpr const char* kRosbag2 = "rosbag2";  // name of its record of metadata

void append_offset(mcap::Bytes& out, Op op, std::uint64_t start, std::uint64_t length) {
  mcap::Output record{out};
  record.begin(Op::kSummaryOffset);
  record.u8(static_cast<std::uint8_t>(op));
  record.u64(start);
  record.u64(length);
  record.end();
}

}  // namespace

bool is_defined(const BagTopic& topic) {
  const rt::DescribedType* type = rt::described_type(topic.type);
  return type != nullptr && (topic.type_hash.empty() || topic.type_hash == type->hash);
}

void McapWriter::Span::add(std::uint64_t time) {
  start = messages == 0 ? time : std::min(start, time);
  end = std::max(end, time);
  ++messages;
}

McapWriter::McapWriter(const std::filesystem::path& file) : name_{file} {
  file_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file_ < 0) throw std::runtime_error(name_ + ": " + std::strerror(errno));
  mcap::Bytes head{mcap::kMagic.begin(), mcap::kMagic.end()};
  mcap::Output record{head};
  record.begin(Op::kHeader);
  record.text("ros2");
  record.text("tandem " TANDEM_VERSION);
  record.end();
  write_file(head);
}

McapWriter::~McapWriter() { ::close(file_); }

// The file ends with a whole record also if the disk is full.
void McapWriter::write_file(mcap::View bytes) {
  const mcap::View all = bytes;
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int error = errno;
      if (ftruncate(file_, static_cast<off_t>(size_)) == 0)
        (void)lseek(file_, static_cast<off_t>(size_), SEEK_SET);
      throw std::runtime_error(name_ + ": cannot be written: " + std::strerror(error) +
                               (error == ENOSPC ? "; free some disk space" : ""));
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  size_ += all.size();
  sum_ = mcap::crc32(all, sum_);
}

std::uint16_t McapWriter::schema_of(const BagTopic& topic) {
  const auto [known, is_new] = schemas_.try_emplace({topic.type, topic.type_hash});
  mcap::Schema& schema = known->second;
  if (!is_new) return schema.id;
  const std::string definition = is_defined(topic) ? *rt::ros2msg(topic.type) : "";
  schema = {static_cast<std::uint16_t>(schemas_.size()), topic.type,
            definition.empty() ? "" : "ros2msg", definition};
  mcap::Output{waiting_}.record(schema);
  return schema.id;
}

void McapWriter::add_topic(int id, const BagTopic& topic) {
  if (id < 0 || id > 0xffff) throw std::runtime_error(name_ + ": more than 65536 topics");
  const auto channel_id = static_cast<std::uint16_t>(id);
  mcap::Channel channel{channel_id, schema_of(topic), topic.name, "cdr", {}};
  channel.metadata["offered_qos_profiles"] = qos_yaml(topic.qos, QosForm::kWords);
  channel.metadata["topic_type_hash"] = topic.type_hash;
  mcap::Output{waiting_}.record(channel);
  channels_[channel_id] = channel;
  counts_[channel_id] = 0;
}

void McapWriter::write(int topic, std::int64_t time, std::span<const std::uint8_t> bytes) {
  const auto channel = static_cast<std::uint16_t>(topic);
  const auto stamp = static_cast<std::uint64_t>(std::max<std::int64_t>(time, 0));
  std::uint64_t& count = counts_.at(channel);
  waiting_index_[channel].emplace_back(stamp, waiting_.size());
  mcap::Output record{waiting_};
  record.begin(Op::kMessage);
  record.u16(channel);
  record.u32(static_cast<std::uint32_t>(count++));
  record.u64(stamp);
  record.u64(stamp);  // of publication: unknown
  record.raw(bytes);
  record.end();
  waiting_span_.add(stamp);
  all_.add(stamp);
  if (waiting_.size() >= kChunkSize) flush();
}

McapWriter::ChunkPlace McapWriter::append_chunk(mcap::Bytes& out) const {
  const auto packed = compress(waiting_);
  ChunkPlace place{.span = waiting_span_,
                   .offset = size_ + out.size(),
                   .size = waiting_.size(),
                   .packed_size = packed.size(),
                   .index_offsets = {}};
  mcap::Output record{out};
  record.begin(Op::kChunk);
  record.u64(waiting_span_.start);
  record.u64(waiting_span_.end);
  record.u64(waiting_.size());
  record.u32(mcap::crc32(waiting_));
  record.text(kZstd);
  record.u64(packed.size());
  record.raw(packed);
  record.end();
  const std::uint64_t end = size_ + out.size();
  place.length = end - place.offset;
  for (const auto& [channel, entries] : waiting_index_) {
    place.index_offsets[channel] = size_ + out.size();
    record.begin(Op::kMessageIndex);
    record.u16(channel);
    record.u32(static_cast<std::uint32_t>(entries.size() * 16));
    for (const auto& [time, offset] : entries) {
      record.u64(time);
      record.u64(offset);
    }
    record.end();
  }
  place.index_length = size_ + out.size() - end;
  return place;
}

void McapWriter::flush() {
  if (waiting_.empty()) return;
  mcap::Bytes out;
  ChunkPlace place = append_chunk(out);
  write_file(out);
  chunks_.push_back(std::move(place));
  waiting_.clear();
  waiting_index_.clear();
  waiting_span_ = {};
}

void McapWriter::close(const std::string& metadata) {
  flush();
  mcap::Bytes out;
  append_data_end(out, metadata);
  append_summary(out);
  out.insert(out.end(), mcap::kMagic.begin(), mcap::kMagic.end());
  write_file(out);
}

void McapWriter::append_data_end(mcap::Bytes& out, const std::string& metadata) {
  mcap::Output record{out};
  metadata_offset_ = size_;
  record.begin(Op::kMetadata);
  record.text(kRosbag2);
  record.map({{"serialized_metadata", metadata}});
  record.end();
  metadata_length_ = out.size();
  const std::uint32_t sum = mcap::crc32(out, sum_);
  record.begin(Op::kDataEnd);
  record.u32(sum);
  record.end();
}

void McapWriter::append_summary(mcap::Bytes& out) {
  const std::size_t start = out.size();
  mcap::Output record{out};
  mcap::Bytes offsets;
  std::size_t group = start;
  const auto end_group = [&](Op op) {
    if (out.size() > group) append_offset(offsets, op, size_ + group, out.size() - group);
    group = out.size();
  };
  for (const auto& [type, schema] : schemas_) record.record(schema);
  end_group(Op::kSchema);
  for (const auto& [id, channel] : channels_) record.record(channel);
  end_group(Op::kChannel);
  append_statistics(record);
  end_group(Op::kStatistics);
  append_chunk_indexes(record);
  end_group(Op::kChunkIndex);
  record.begin(Op::kMetadataIndex);
  record.u64(metadata_offset_);
  record.u64(metadata_length_);
  record.text(kRosbag2);
  record.end();
  end_group(Op::kMetadataIndex);
  const std::uint64_t offsets_start = size_ + out.size();
  record.raw(offsets);
  record.u8(static_cast<std::uint8_t>(Op::kFooter));
  record.u64(mcap::kFooterSize);
  record.u64(size_ + start);
  record.u64(offsets_start);
  record.u32(mcap::crc32(mcap::View{out}.subspan(start)));  // of the footer's head, too
}

void McapWriter::append_chunk_indexes(mcap::Output& record) const {
  for (const ChunkPlace& chunk : chunks_) {
    record.begin(Op::kChunkIndex);
    record.u64(chunk.span.start);
    record.u64(chunk.span.end);
    record.u64(chunk.offset);
    record.u64(chunk.length);
    record.u32(static_cast<std::uint32_t>(chunk.index_offsets.size() * 10));
    for (const auto& [channel, offset] : chunk.index_offsets) {
      record.u16(channel);
      record.u64(offset);
    }
    record.u64(chunk.index_length);
    record.text(kZstd);
    record.u64(chunk.packed_size);
    record.u64(chunk.size);
    record.end();
  }
}

void McapWriter::append_statistics(mcap::Output& record) const {
  record.begin(Op::kStatistics);
  record.u64(all_.messages);
  record.u16(static_cast<std::uint16_t>(schemas_.size()));
  record.u32(static_cast<std::uint32_t>(channels_.size()));
  record.u32(0);  // attachments
  record.u32(1);  // records of metadata
  record.u32(static_cast<std::uint32_t>(chunks_.size()));
  record.u64(all_.start);
  record.u64(all_.end);
  record.u32(static_cast<std::uint32_t>(counts_.size() * 10));
  for (const auto& [channel, count] : counts_) {
    record.u16(channel);
    record.u64(count);
  }
  record.end();
}

}  // namespace tandem
