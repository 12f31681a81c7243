// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/mcap_scan.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "bringup/bag/lz4.hpp"
#include "bringup/bag/zstd.hpp"

namespace tandem::mcap {
namespace {

constexpr std::uint64_t kChunkFields = 128;   // [bytes] more than a chunk has before its records
constexpr std::uint64_t kMessageFields = 22;  // [bytes] before a message's data
constexpr std::uint64_t kTail = kHead + kFooterSize + kMagic.size();  // [bytes]

// Adds a schema or a channel; one of a known id must be the same, or messages would be mistaken.
template <class Record>
void add(std::map<std::uint16_t, Record>& known, Record record, const char* kind) {
  const auto [place, is_new] = known.try_emplace(record.id, record);
  if (!is_new && place->second != record)
    throw std::runtime_error(std::string{"two different "} + kind + " have the number " +
                             std::to_string(record.id));
}

void learn(Op op, View content, Contents& contents) {
  if (op == Op::kSchema) add(contents.schemas, Input{content}.schema(), "schemas");
  if (op == Op::kChannel) add(contents.channels, Input{content}.channel(), "channels");
}

class Scanner {
 public:
  explicit Scanner(const File& file) : file_{file} {}

  Contents run() {
    const Bytes magic = file_.size() < kMagic.size() ? Bytes{} : file_.read(0, kMagic.size());
    if (!std::ranges::equal(magic, kMagic)) file_.fail(0, "this is no MCAP file");
    has_end_ = file_.size() >= kTail + kMagic.size() &&
               std::ranges::equal(file_.read(file_.size() - kMagic.size(), kMagic.size()), kMagic);
    while (!is_over_ && step()) {
    }
    if (!has_end_) contents_.cut_at = offset_;
    if (!has_summary()) learn_from_chunks();
    return std::move(contents_);
  }

 private:
  // Reads the head of one record. False at the end of a file that was cut off.
  bool step() {
    if (file_.size() - offset_ < kHead) return cut("the records end without a footer");
    const Bytes head = file_.read(offset_, kHead);
    Input in{head};
    const auto op = static_cast<Op>(in.u8());
    const std::uint64_t size = in.u64(), content = offset_ + kHead;
    if (op == Op{0}) return cut("a record has the invalid opcode 0");  // zeros: power was lost
    if (size > file_.size() - content) return cut("a record claims to be longer than the file");
    try {
      take(op, content, size);
    } catch (const ShortRecord& error) {
      file_.fail(offset_, error.what());
    }
    offset_ = content + size;
    return true;
  }

  [[nodiscard]] bool cut(const char* what) const {
    if (has_end_) file_.fail(offset_, what);
    return false;
  }

  void take(Op op, std::uint64_t content, std::uint64_t size) {
    const auto begin = [&](std::uint64_t most) {
      return file_.read(content, std::min(size, most));
    };
    if (op == Op::kDataEnd || op == Op::kFooter) {
      is_over_ = true;
    } else if (op == Op::kSchema || op == Op::kChannel) {
      learn_at(op, begin(size), offset_);
    } else if (op == Op::kMessage) {
      contents_.places.push_back(
          {Input{begin(kMessageFields)}.message().time, content, size, false});
    } else if (op == Op::kChunk) {
      ++chunks_;
      const Chunk chunk = Input{begin(kChunkFields)}.chunk();
      contents_.places.push_back({chunk.start, content, size, true});
    }
  }

  void learn_at(Op op, View content, std::uint64_t offset) {
    try {
      learn(op, content, contents_);
    } catch (const std::runtime_error& error) {
      file_.fail(offset, error.what());
    }
  }

  // Takes the channels from the summary, if it is whole and knows of all chunks. A damaged one is
  // not needed.
  bool has_summary() {
    if (!has_end_) return false;
    try {
      const std::uint64_t footer = file_.size() - kTail;
      const Bytes tail = file_.read(footer, kHead + kFooterSize);
      Input in{tail};
      if (static_cast<Op>(in.u8()) != Op::kFooter || in.u64() != kFooterSize) return false;
      const std::uint64_t start = in.u64();
      (void)in.u64();  // of the summary's own index
      if (start < kMagic.size() || start > footer) return false;
      const Bytes summary = file_.read(start, file_.size() - kMagic.size() - 4 - start);
      const std::uint32_t sum = in.u32();
      return (sum == 0 || sum == crc32(summary)) &&
             learn_from_summary(View{summary}.first(static_cast<std::size_t>(footer - start)));
    } catch (const std::runtime_error&) {
      return false;
    }
  }

  bool learn_from_summary(View summary) {
    Contents found = contents_;
    std::size_t indexed = 0;
    for_each_record(summary, [&](Op op, View content, std::size_t) {
      learn(op, content, found);
      if (op == Op::kChunkIndex) ++indexed;
    });
    if (indexed != chunks_) return false;
    contents_ = std::move(found);
    return true;
  }

  void learn_from_chunks() {
    for (const Place& place : contents_.places)
      if (place.is_chunk) learn_from(place);
  }

  void learn_from(const Place& place) {
    const Bytes records = records_of(file_, place);
    try {
      for_each_record(records,
                      [&](Op op, View content, std::size_t) { learn(op, content, contents_); });
    } catch (const std::runtime_error& error) {
      file_.fail(place.offset, std::string{"within a chunk, "} + error.what());
    }
  }

  const File& file_;
  Contents contents_;
  std::uint64_t offset_ = kMagic.size();
  std::size_t chunks_ = 0;
  bool has_end_ = false, is_over_ = false;
};

struct UnknownCompression {};

Bytes unpack(const Chunk& chunk, View packed) {
  if (chunk.size > kLargestMessage) throw std::runtime_error("it claims to have more than 1 GiB");
  const auto limit = static_cast<std::size_t>(chunk.size);
  if (chunk.compression.empty()) return {packed.begin(), packed.end()};
  if (chunk.compression == "zstd") return decompress(packed, limit);
  if (chunk.compression == "lz4" && kHasLz4) return decompress_lz4(packed, limit);
  throw UnknownCompression{};
}

}  // namespace

File::File(const std::filesystem::path& path, std::string name)
    : name_{std::move(name)}, file_{::open(path.c_str(), O_RDONLY | O_CLOEXEC)} {
  struct stat about {};
  if (file_ < 0 || fstat(file_, &about) != 0)
    throw std::runtime_error(name_ + ": " + std::strerror(errno));
  size_ = static_cast<std::uint64_t>(about.st_size);
}

File::~File() {
  if (file_ >= 0) ::close(file_);
}

Bytes File::read(std::uint64_t offset, std::uint64_t size) const {
  if (offset > size_ || size > size_ - offset) fail(offset, "the file ends here");
  if (size > kLargestMessage) fail(offset, "a record is larger than 1 GiB");
  Bytes bytes(static_cast<std::size_t>(size));
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got =
        pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw std::runtime_error(name_ + ": " + std::strerror(errno));
    if (got == 0) fail(offset + done, "the file became shorter while it was read");
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

void File::fail(std::uint64_t offset, const std::string& what) const {
  throw std::runtime_error(name_ + ": byte " + std::to_string(offset) + ": " + what +
                           "; recover what is left of it: mcap recover " + name_ +
                           " -o saved.mcap");
}

Contents scan(const File& file) { return Scanner{file}.run(); }

Bytes records_of(const File& file, const Place& place) {
  const Bytes content = file.read(place.offset, place.size);
  Chunk chunk;
  try {
    Input in{content};
    chunk = in.chunk();
    Bytes records = unpack(chunk, in.raw(chunk.packed_size));
    if (records.size() != chunk.size)
      throw std::runtime_error("it has not the size that it claims");
    if (chunk.crc != 0 && chunk.crc != crc32(records))
      throw std::runtime_error("its checksum is wrong");
    return records;
  } catch (const UnknownCompression&) {
    throw std::runtime_error(file.name() + ": byte " + std::to_string(place.offset) +
                             ": a chunk is compressed with '" + chunk.compression +
                             "', which this build of Tandem cannot read; rewrite it: mcap compress "
                             "--compression zstd " +
                             file.name() + " -o readable.mcap");
  } catch (const std::runtime_error& error) {
    file.fail(place.offset, std::string{"a chunk cannot be read: "} + error.what());
  }
}

}  // namespace tandem::mcap
