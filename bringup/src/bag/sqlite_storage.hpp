// SPDX-License-Identifier: Apache-2.0
// Writes and reads rosbag2's SQLite files, in the format of ROS 2 Humble, which every later release
// reads.
#pragma once

#include <map>

#include "bringup/bag/bag_database.hpp"
#include "bringup/bag/bag_storage.hpp"

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
  BagDatabase database_;
  BagStatement insert_;
};

class SqliteReader : public BagFileReader {
 public:
  /// `name` and `is_temporary`: as open_database() takes them.
  SqliteReader(const std::string& file, const std::string& name, bool is_temporary);

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::int64_t first() const override { return first_; }
  [[nodiscard]] bool next(BagMessage& message) override;

 private:
  BagDatabase database_;
  BagStatement select_;
  std::vector<BagTopic> topics_;
  std::map<std::int64_t, std::size_t> index_;  // into topics_, by the file's ids
  std::int64_t first_ = 0;
};

}  // namespace tandem
