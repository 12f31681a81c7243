// SPDX-License-Identifier: Apache-2.0
// Makes MCAP files record by record, also such as our writer never makes.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "bringup/bag/mcap_format.hpp"

namespace tandem::test {

using mcap::Bytes;
using mcap::Op;

/// The records of a file, or of a chunk.
class McapRecords {
 public:
  McapRecords& schema(std::uint16_t id = 1, const std::string& type = "std_msgs/msg/Bool") {
    mcap::Output{bytes_}.record(mcap::Schema{id, type, "ros2msg", "bool data\n"});
    return *this;
  }
  McapRecords& channel(std::uint16_t id = 1, const std::string& topic = "/a",
                       const std::string& encoding = "cdr", std::uint16_t schema = 1) {
    mcap::Output{bytes_}.record(mcap::Channel{id, schema, topic, encoding, {}});
    return *this;
  }
  McapRecords& message(std::uint64_t time, std::uint8_t value, std::uint16_t channel = 1) {
    return record(Op::kMessage, [&](mcap::Output& out) {
      out.u16(channel);
      out.u32(0);
      out.u64(time);
      out.u64(time);
      out.raw(Bytes{0, 1, 0, 0, value});
    });
  }
  /// `packed`: the records as they are stored.
  McapRecords& chunk(const Bytes& packed, std::uint64_t size, std::uint32_t crc = 0,
                     const std::string& compression = "", std::uint64_t start = 1) {
    return record(Op::kChunk, [&](mcap::Output& out) {
      out.u64(start);
      out.u64(start);
      out.u64(size);
      out.u32(crc);
      out.text(compression);
      out.u64(packed.size());
      out.raw(packed);
    });
  }
  McapRecords& chunk(const McapRecords& records, std::uint64_t start = 1) {
    return chunk(records.bytes(), records.bytes().size(), mcap::crc32(records.bytes()), "", start);
  }
  McapRecords& record(Op op, const std::function<void(mcap::Output&)>& fields) {
    mcap::Output out{bytes_};
    out.begin(op);
    fields(out);
    out.end();
    return *this;
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

/// A whole file of these records, without a summary.
inline Bytes mcap_file(const McapRecords& records) {
  Bytes file{mcap::kMagic.begin(), mcap::kMagic.end()};
  McapRecords head, end;
  head.record(Op::kHeader, [](mcap::Output& out) {
    out.text("ros2");
    out.text("test");
  });
  end.record(Op::kDataEnd, [](mcap::Output& out) { out.u32(0); });
  end.record(Op::kFooter, [](mcap::Output& out) {
    out.u64(0);
    out.u64(0);
    out.u32(0);
  });
  mcap::Output out{file};
  out.raw(head.bytes());
  out.raw(records.bytes());
  out.raw(end.bytes());
  out.raw(mcap::kMagic);
  return file;
}

inline Bytes bytes_of(const std::filesystem::path& file) {
  std::ifstream stream{file, std::ios::binary};
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_file(const std::filesystem::path& file, const Bytes& bytes) {
  std::filesystem::remove(file);  // ext4 waits for the disk where a file is replaced by truncation
  std::ofstream{file, std::ios::binary}.write(reinterpret_cast<const char*>(bytes.data()),
                                              static_cast<std::streamsize>(bytes.size()));
}

}  // namespace tandem::test
