// SPDX-License-Identifier: Apache-2.0
// Finds what an MCAP file contains by walking over its records, so that files without an index or
// without an end can be read, too.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "bringup/bag/mcap_format.hpp"

namespace tandem::mcap {

/// A file of which every read is checked against its size when it was opened.
class File {
 public:
  /// `name`: for messages. Throws std::runtime_error if it cannot be opened.
  File(const std::filesystem::path& path, std::string name);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[nodiscard]] std::uint64_t size() const { return size_; }  ///< [bytes]
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Throws std::runtime_error if there are fewer bytes, or the disk cannot read them.
  [[nodiscard]] Bytes read(std::uint64_t offset, std::uint64_t size) const;
  /// Throws std::runtime_error: the file, the byte, what is wrong, and the command that mends it.
  [[noreturn]] void fail(std::uint64_t offset, const std::string& what) const;

 private:
  std::string name_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

/// A chunk or a message outside of chunks. `start`: its first time [ns], as the file says.
struct Place {
  std::uint64_t start = 0, offset = 0;  ///< offset: of its content in the file [bytes]
  std::uint64_t size = 0;               ///< of its content [bytes]
  bool is_chunk = false;
};

/// What a file contains. Channels and schemas are by id.
struct Contents {
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<Place> places;  ///< in the order of the file
  std::optional<std::uint64_t>
      cut_at;  ///< the byte behind the last whole record, if its end is missing
};

/// Reads where everything is, and the channels, for which chunks are decompressed only if the file
/// has no complete summary. Throws std::runtime_error, as File::fail() does, if the file is damaged
/// or no MCAP file.
[[nodiscard]] Contents scan(const File& file);

/// The decompressed records of a chunk. Throws std::runtime_error if it is damaged, if its
/// compression is unknown or not compiled in, or if there are more than 1 GiB of them.
[[nodiscard]] Bytes records_of(const File& file, const Place& chunk);

/// Calls `visit(op, content, offset)` for each of the records of a chunk; `offset` is that of the
/// content. Throws ShortRecord if they end within a record.
template <class Visit>
void for_each_record(View records, const Visit& visit) {
  for (Input in{records}; !in.rest().empty();) {
    const auto op = static_cast<Op>(in.u8());
    const View content = in.raw(in.u64());
    visit(op, content, static_cast<std::size_t>(content.data() - records.data()));
  }
}

}  // namespace tandem::mcap
