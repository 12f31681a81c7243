// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/sqlite_storage.hpp"

#include <sqlite3.h>

#include <stdexcept>

#include "bringup/bag/bag_files.hpp"
#include "bringup/bag/bag_qos.hpp"

namespace tandem {
namespace {

constexpr int kSchemaVersion = 3;  // Humble's
const std::string kContent = "a recording, stored as mcap or sqlite3";

// ROS 2 Eloquent and older have no QoS column.
std::string topics_query(const SqliteDatabase& database) {
  const auto column = sql::prepare(
      database, "SELECT 1 FROM pragma_table_info('topics') WHERE name = 'offered_qos_profiles'");
  const std::string qos = sql::step(database, column) ? "offered_qos_profiles" : "''";
  return "SELECT id, name, type, serialization_format, " + qos + " FROM topics ORDER BY id";
}

void check_format(const SqliteDatabase& database, const std::string& topic,
                  const std::string& format) {
  if (format == "cdr") return;
  throw std::runtime_error(database.name + ": serialization_format of " + topic + " is '" + format +
                           "', not cdr;" + how_to_convert(database.name));
}

}  // namespace

// A write-ahead log lets others read the file while it is written.
SqliteWriter::SqliteWriter(const std::string& file) : database_{create_database(file, kContent)} {
  sql::execute(database_,
               "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;"
               "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
               "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL,"
               " metadata TEXT NOT NULL);"
               "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
               " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
               "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
               " timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
               "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
               "INSERT INTO schema VALUES (" +
                   std::to_string(kSchemaVersion) + ", 'humble'); BEGIN");
  insert_ =
      sql::prepare(database_, "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)");
}

void SqliteWriter::add_topic(int id, const BagTopic& topic) {
  const auto statement =
      sql::prepare(database_,
                   "INSERT INTO topics (id, name, type, serialization_format, offered_qos_profiles)"
                   " VALUES (?, ?, ?, 'cdr', ?)");
  sqlite3_bind_int(statement.get(), 1, id);
  sql::bind_text(statement, 2, topic.name);
  sql::bind_text(statement, 3, topic.type);
  sql::bind_text(statement, 4, qos_yaml(topic.qos, QosForm::kNumbers));
  if (sqlite3_step(statement.get()) != SQLITE_DONE) sql::fail(database_);
}

void SqliteWriter::write(int topic, std::int64_t time, std::span<const std::uint8_t> bytes) {
  sqlite3_bind_int(insert_.get(), 1, topic);
  sqlite3_bind_int64(insert_.get(), 2, time);
  const void* data = bytes.empty() ? static_cast<const void*>("") : bytes.data();  // not NULL
  sqlite3_bind_blob64(insert_.get(), 3, data, bytes.size(), SQLITE_STATIC);
  const int result = sqlite3_step(insert_.get());
  sqlite3_reset(insert_.get());
  if (result != SQLITE_DONE) sql::fail(database_);
}

void SqliteWriter::flush() { sql::execute(database_, "COMMIT; BEGIN"); }

void SqliteWriter::close(const std::string& /*metadata*/) {
  insert_.reset();
  sql::execute(database_, "COMMIT; PRAGMA journal_mode=DELETE");  // leaves a single file
}

SqliteReader::SqliteReader(const std::string& file, const std::string& name, bool is_temporary)
    : database_{open_database({file, name, is_temporary}, kContent)} {
  const auto rows = sql::prepare(database_, topics_query(database_));
  while (sql::step(database_, rows)) {
    const std::string topic = sql::text(rows, 1);
    check_format(database_, topic, sql::text(rows, 3));
    index_[sqlite3_column_int64(rows.get(), 0)] = topics_.size();
    topics_.push_back({topic, sql::text(rows, 2), recorded_qos(topic, sql::text(rows, 4))});
  }
  const auto first = sql::prepare(database_, "SELECT MIN(timestamp) FROM messages");
  if (sql::step(database_, first)) first_ = sqlite3_column_int64(first.get(), 0);
}

bool SqliteReader::next(BagMessage& message) {
  if (!select_)
    select_ = sql::prepare(database_,
                           "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id");
  while (sql::step(database_, select_)) {
    // Unknown topic id: the file is damaged, or it is still being written and the topic was added
    // after the file was opened.
    const auto topic = index_.find(sqlite3_column_int64(select_.get(), 0));
    if (topic == index_.end()) continue;
    message.topic = topic->second;
    message.time = sqlite3_column_int64(select_.get(), 1);
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(select_.get(), 2));
    message.bytes.assign(data, data + sqlite3_column_bytes(select_.get(), 2));
    return true;
  }
  return false;
}

}  // namespace tandem
