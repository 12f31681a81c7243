// SPDX-License-Identifier: Apache-2.0
// Writes and reads rosbag2 recordings: a folder with one file, MCAP or SQLite, and metadata.yaml.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bringup/bag/bag_files.hpp"
#include "bringup/bag/bag_storage.hpp"

namespace tandem {

/// Writes a recording. Committed messages survive a crash of the process.
class BagWriter {
 public:
  /// Throws std::runtime_error if `folder` already exists or cannot be created.
  explicit BagWriter(const std::string& folder, BagStorage storage = BagStorage::kMcap);
  /// Commits, and ends the file.
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// Returns the id to pass to write(). Throws std::runtime_error if the file cannot be written,
  /// for example because the disk is full.
  int add_topic(const BagTopic& topic);
  /// `time` [ns since 1970]. Throws std::runtime_error as add_topic() does.
  void write(int topic, std::int64_t time, const std::vector<std::uint8_t>& bytes);
  /// Commits everything written so far and updates metadata.yaml. Throws as add_topic() does.
  void commit();
  [[nodiscard]] std::int64_t messages() const { return metadata_.messages; }

 private:
  std::string folder_;
  BagMetadata metadata_;
  std::unique_ptr<BagFileWriter> file_;
};

/// Reads a recording in order of time. It may be split into several files and compressed with zstd,
/// per message or per file; a compressed file needs space in the folder for temporary files.
class BagReader {
 public:
  /// `path`: the folder, or one of its files (.mcap, .db3, or either with .zstd). Throws
  /// std::runtime_error if it is not a recording or uses another storage, compression or
  /// serialization format. What is missing at the end of an MCAP file is logged once in a process.
  explicit BagReader(const std::string& path);

  [[nodiscard]] const std::vector<BagTopic>& topics() const { return topics_; }
  /// False after the last message. If the recording is still being written, topics added after it
  /// was opened are left out, of an MCAP file also later messages. Throws std::runtime_error if the
  /// recording is damaged.
  [[nodiscard]] bool next(BagMessage& message);
  /// Total clock adjustment within the messages read so far [ns].
  [[nodiscard]] std::int64_t skipped() const { return skipped_; }

 private:
  struct File {
    std::string name;
    std::unique_ptr<BagFileReader> reader;
    std::vector<std::size_t> index;  // into topics_, by the file's
  };

  void add(const std::string& file);
  void decompress_message(BagMessage& message) const;
  [[nodiscard]] std::int64_t without_gap(std::int64_t stamp);

  std::vector<BagTopic> topics_;
  std::vector<File> files_;  // the last one is read next
  std::optional<std::int64_t> last_stamp_;
  std::int64_t skipped_ = 0;
};

}  // namespace tandem
