// SPDX-License-Identifier: Apache-2.0
// Writes and reads rosbag2 recordings (a folder with one SQLite file and metadata.yaml), in the
// format of ROS 2 Humble, which every later release reads.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bringup/bag/bag_database.hpp"
#include "tandem/runtime/qos.hpp"

namespace tandem {

/// A recorded topic.
struct BagTopic {
  std::string name, type;  ///< "/cmd_vel", "geometry_msgs/msg/Twist"
  rt::QoS qos{};           ///< offered by its publishers
};

/// One recorded message: its receive time [ns since 1970] and its uncompressed CDR, encapsulation
/// header included. If the clock was set by more than a day during the recording, later timestamps
/// continue from the earlier ones.
struct BagMessage {
  std::size_t topic = 0;  ///< index into BagReader::topics()
  std::int64_t time = 0;
  std::vector<std::uint8_t> bytes;
};

/// Writes a recording. Committed messages survive a crash of the process.
class BagWriter {
 public:
  /// Throws std::runtime_error if `folder` already exists or cannot be created.
  explicit BagWriter(const std::string& folder);
  /// Commits.
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// Returns the id to pass to write(). Throws std::runtime_error if SQLite cannot write, for
  /// example because the disk is full.
  int add_topic(const BagTopic& topic);
  /// Throws std::runtime_error if SQLite cannot write, for example because the disk is full.
  void write(int topic, std::int64_t time, const std::vector<std::uint8_t>& bytes);
  /// Commits everything written so far and updates metadata.yaml.
  void commit();
  [[nodiscard]] std::int64_t messages() const { return messages_; }

 private:
  struct Count {
    BagTopic topic;
    std::int64_t messages = 0;
  };

  void write_metadata() const;

  std::string folder_, file_;
  BagDatabase database_;
  BagStatement insert_;
  std::map<int, Count> topics_;
  std::int64_t messages_ = 0, first_ = 0, last_ = 0;
};

/// Whether the path is a folder or is named like a recording's file.
[[nodiscard]] bool is_recording(const std::string& path);

/// Reads a recording in order of time. It may be split into several files and compressed with zstd,
/// per message or per file; a compressed file needs space in the folder for temporary files.
class BagReader {
 public:
  /// `path`: the folder, or one .db3 or .db3.zstd. Throws std::runtime_error if it is not a
  /// recording or uses another storage, compression or serialization format.
  explicit BagReader(const std::string& path);

  [[nodiscard]] const std::vector<BagTopic>& topics() const { return topics_; }
  /// False after the last message. If the recording is still being written, topics added after it
  /// was opened are skipped. Throws std::runtime_error if the file is damaged.
  bool next(BagMessage& message);
  /// Total clock adjustment within the messages read so far [ns].
  [[nodiscard]] std::int64_t skipped() const { return skipped_; }

 private:
  struct File {
    BagDatabase database;
    std::int64_t first = 0;                     // time of its first message
    std::map<std::int64_t, std::size_t> index;  // into topics_, by the file's ids
  };

  void add(const std::string& file);
  [[nodiscard]] std::vector<std::uint8_t> plain_bytes(const File& file) const;
  [[nodiscard]] std::int64_t without_gap(std::int64_t stamp);

  std::vector<BagTopic> topics_;
  std::vector<File> files_;  // the last one is read next
  BagStatement select_;
  std::optional<std::int64_t> last_stamp_;
  std::int64_t skipped_ = 0;
};

}  // namespace tandem
