// SPDX-License-Identifier: Apache-2.0
// Writes and reads rosbag2's SQLite files, in the format of ROS 2 Humble, which every later release
// reads.
#pragma once

#include <map>

#include "bringup/bag/bag_storage.hpp"
#include "bringup/sqlite/sqlite_database.hpp"

namespace tandem {

class SqliteWriter : public BagFileWriter {
 public:
  /// Throws std::runtime_error if the file cannot be created.
  explicit SqliteWriter(const std::string& file);

  void add_topic(int id, const BagTopic& topic) override;
  void write(int topic, std::int64_t time, std::span<const std::uint8_t> bytes) override;
  void flush() override;
  void close(const std::string& metadata) override;

 private:
  SqliteDatabase database_;
  SqliteStatement insert_;
};

class SqliteReader : public BagFileReader {
 public:
  /// `name` and `is_temporary`: as in SqliteFile.
  SqliteReader(const std::string& file, const std::string& name, bool is_temporary);

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::int64_t first() const override { return first_; }
  [[nodiscard]] bool next(BagMessage& message) override;

 private:
  SqliteDatabase database_;
  SqliteStatement select_;
  std::vector<BagTopic> topics_;
  std::map<std::int64_t, std::size_t> index_;  // into topics_, by the file's ids
  std::int64_t first_ = 0;
};

}  // namespace tandem
