// SPDX-License-Identifier: Apache-2.0
// What the storages of a recording (SQLite, MCAP) have in common: one file is written or read
// through these interfaces. BagWriter and BagReader add metadata.yaml and the order of files.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/runtime/qos.hpp"

namespace tandem {

/// A recorded topic.
struct BagTopic {
  std::string name, type;  ///< "/cmd_vel", "geometry_msgs/msg/Twist"
  rt::QoS qos{};           ///< offered by its publishers
  std::string
      type_hash{};  ///< "RIHS01_…"; empty: that of the type as Tandem defines it, if it does
};

/// One recorded message: its receive time [ns since 1970] and its uncompressed CDR, encapsulation
/// header included. If the clock was set by more than a day during the recording, later timestamps
/// continue from the earlier ones.
struct BagMessage {
  std::size_t topic = 0;  ///< index into BagReader::topics()
  std::int64_t time = 0;
  std::vector<std::uint8_t> bytes;
};

/// Writes one file. All functions throw std::runtime_error, which names the file, if it cannot be
/// written, for example because the disk is full.
class BagFileWriter {
 public:
  virtual ~BagFileWriter() = default;

  /// `id`: from 1, not used before. `topic` has the hash of its type, if one is known.
  virtual void add_topic(int id, const BagTopic& topic) = 0;
  /// `topic`: an id of add_topic(). `time` [ns since 1970], not negative.
  virtual void write(int topic, std::int64_t time, std::span<const std::uint8_t> bytes) = 0;
  /// Hands everything written so far to the operating system: it survives a crash of the process.
  virtual void flush() = 0;
  /// Ends the file. `metadata`: what metadata.yaml says below its topmost key.
  virtual void close(const std::string& metadata) = 0;
};

/// Reads one file in order of time.
class BagFileReader {
 public:
  virtual ~BagFileReader() = default;

  [[nodiscard]] virtual const std::vector<BagTopic>& topics() const = 0;
  /// Time of the first message [ns since 1970]; 0 without messages.
  [[nodiscard]] virtual std::int64_t first() const = 0;
  /// False after the last message. `message.topic` is an index into topics(), its time as recorded.
  /// Throws std::runtime_error, which names the file, if the file is damaged.
  [[nodiscard]] virtual bool next(BagMessage& message) = 0;
};

}  // namespace tandem
