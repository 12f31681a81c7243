// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/bag.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string_view>

#include <yaml-cpp/yaml.h>

#include "bringup/bag/bag_qos.hpp"
#include "bringup/bag/zstd.hpp"
#include "tandem/config/yaml_document.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr int kMetadataVersion = 5, kSchemaVersion = 3;  // Humble's
constexpr const char* kMetadataFile = "metadata.yaml";
constexpr std::string_view kPlain = ".db3", kCompressed = kCompressedDatabase;
constexpr std::int64_t kLongestPause = 86'400'000'000'000;  // [ns] one day

using Database = BagDatabase;
using Statement = BagStatement;

void emit_topic(YAML::Emitter& out, const BagTopic& topic, std::int64_t messages) {
  out << YAML::BeginMap << YAML::Key << "topic_metadata" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "name" << YAML::Value << topic.name;
  out << YAML::Key << "type" << YAML::Value << topic.type;
  out << YAML::Key << "serialization_format" << YAML::Value << "cdr";
  out << YAML::Key << "offered_qos_profiles" << YAML::Value << YAML::DoubleQuoted
      << qos_yaml(topic.qos);
  out << YAML::EndMap;
  out << YAML::Key << "message_count" << YAML::Value << messages << YAML::EndMap;
}

void emit_span(YAML::Emitter& out, std::int64_t first, std::int64_t last, std::int64_t messages) {
  out << YAML::Key << "duration" << YAML::Value << YAML::BeginMap << YAML::Key << "nanoseconds"
      << YAML::Value << last - first << YAML::EndMap;
  out << YAML::Key << "starting_time" << YAML::Value << YAML::BeginMap << YAML::Key
      << "nanoseconds_since_epoch" << YAML::Value << first << YAML::EndMap;
  out << YAML::Key << "message_count" << YAML::Value << messages;
}

// Rejects recordings whose metadata.yaml names an unsupported format. The file may be missing: the
// databases contain everything else.
void check_metadata(const fs::path& folder) {
  const std::string file = folder / kMetadataFile;
  const auto refuse_unless = [&](const std::string& field, const std::string& value,
                                 const std::string& readable) {
    if (!value.empty() && value != readable)
      throw std::runtime_error(file + ": " + field + " is '" + value + "', not " + readable + ";" +
                               how_to_convert(folder.string()));
  };
  std::string storage, format;
  try {
    const YAML::Node info = load_document(file)["rosbag2_bagfile_information"];
    storage = info["storage_identifier"].as<std::string>("");
    format = info["compression_format"].as<std::string>("");
  } catch (const std::exception&) {
    return;  // a killed recorder leaves no metadata
  }
  refuse_unless("storage_identifier", storage, "sqlite3");
  refuse_unless("compression_format", format, "zstd");
}

// The folder's database files. rosbag2 leaves a decompressed .db3 next to the compressed original.
std::vector<std::string> databases_in(const std::string& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator{path}) {
    const std::string file = entry.path();
    const bool is_copy =
        file.ends_with(kCompressed) && fs::exists(fs::path{file}.replace_extension());
    if ((file.ends_with(kPlain) || file.ends_with(kCompressed)) && !is_copy) files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  if (!files.empty()) return files;
  throw std::runtime_error(
      path +
      " contains no .db3; is it a recording stored as sqlite3 rather than mcap? If it is mcap," +
      how_to_convert(path));
}

// ROS 2 Eloquent and older have no QoS column.
std::string topics_query(const Database& database) {
  const auto column = sql::prepare(
      database, "SELECT 1 FROM pragma_table_info('topics') WHERE name = 'offered_qos_profiles'");
  const std::string qos = sql::step(database, column) ? "offered_qos_profiles" : "''";
  return "SELECT id, name, type, serialization_format, " + qos + " FROM topics ORDER BY id";
}

void check_format(const Database& database, const std::string& topic, const std::string& format) {
  if (format == "cdr") return;
  throw std::runtime_error(database.name + ": serialization_format of " + topic + " is '" + format +
                           "', not cdr;" + how_to_convert(database.name));
}

}  // namespace

BagWriter::BagWriter(const std::string& folder) : folder_{folder} {
  if (fs::exists(folder)) throw std::runtime_error(folder + " already exists");
  fs::create_directories(folder);
  const fs::path path{folder};
  const std::string stem = path.has_filename() ? path.filename() : path.parent_path().filename();
  file_ = stem + "_0.db3";
  database_ = create_database(path / file_);
  // A write-ahead log lets others read the file while it is written.
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
  write_metadata();
}

BagWriter::~BagWriter() {
  try {
    commit();
    insert_.reset();
    sql::execute(database_, "COMMIT; PRAGMA journal_mode=DELETE");  // leaves a single file
  } catch (const std::exception&) {  // reported before, or the disk is full: nothing left to do
  }
}

int BagWriter::add_topic(const BagTopic& topic) {
  const auto statement =
      sql::prepare(database_,
                   "INSERT INTO topics (name, type, serialization_format, offered_qos_profiles)"
                   " VALUES (?, ?, 'cdr', ?)");
  sql::bind_text(statement, 1, topic.name);
  sql::bind_text(statement, 2, topic.type);
  sql::bind_text(statement, 3, qos_yaml(topic.qos));
  if (sqlite3_step(statement.get()) != SQLITE_DONE) sql::fail(database_);
  const int id = static_cast<int>(sqlite3_last_insert_rowid(database_.handle.get()));
  topics_[id] = {topic, 0};
  return id;
}

void BagWriter::write(int topic, std::int64_t time, const std::vector<std::uint8_t>& bytes) {
  sqlite3_bind_int(insert_.get(), 1, topic);
  sqlite3_bind_int64(insert_.get(), 2, time);
  const void* data = bytes.empty() ? static_cast<const void*>("") : bytes.data();  // not NULL
  sqlite3_bind_blob64(insert_.get(), 3, data, bytes.size(), SQLITE_STATIC);
  const int result = sqlite3_step(insert_.get());
  sqlite3_reset(insert_.get());
  if (result != SQLITE_DONE) sql::fail(database_);
  if (messages_++ == 0) first_ = last_ = time;
  first_ = std::min(first_, time);
  last_ = std::max(last_, time);
  ++topics_.at(topic).messages;
}

void BagWriter::commit() {
  sql::execute(database_, "COMMIT; BEGIN");
  write_metadata();
}

void BagWriter::write_metadata() const {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "rosbag2_bagfile_information" << YAML::Value;
  out << YAML::BeginMap << YAML::Key << "version" << YAML::Value << kMetadataVersion;
  out << YAML::Key << "storage_identifier" << YAML::Value << "sqlite3";
  emit_span(out, first_, last_, messages_);
  out << YAML::Key << "topics_with_message_count" << YAML::Value << YAML::BeginSeq;
  for (const auto& [id, count] : topics_) emit_topic(out, count.topic, count.messages);
  out << YAML::EndSeq;
  out << YAML::Key << "compression_format" << YAML::Value << YAML::DoubleQuoted << "";
  out << YAML::Key << "compression_mode" << YAML::Value << YAML::DoubleQuoted << "";
  out << YAML::Key << "relative_file_paths" << YAML::Value << YAML::BeginSeq << file_
      << YAML::EndSeq;
  out << YAML::Key << "files" << YAML::Value << YAML::BeginSeq << YAML::BeginMap;
  out << YAML::Key << "path" << YAML::Value << file_;
  emit_span(out, first_, last_, messages_);
  out << YAML::EndMap << YAML::EndSeq << YAML::EndMap << YAML::EndMap;

  const fs::path path = fs::path{folder_} / kMetadataFile;
  const fs::path fresh = path.string() + ".new";
  std::ofstream{fresh} << out.c_str() << '\n';
  fs::rename(fresh, path);  // atomic: readers never see half a file
}

bool is_recording(const std::string& path) {
  return fs::is_directory(path) || path.ends_with(kPlain) || path.ends_with(kCompressed);
}

BagReader::BagReader(const std::string& path) {
  check_metadata(fs::is_directory(path) ? fs::path{path} : fs::path{path}.parent_path());
  for (const auto& file : databases_in(path)) add(file);
  std::stable_sort(files_.begin(), files_.end(),
                   [](const File& a, const File& b) { return a.first > b.first; });
}

void BagReader::add(const std::string& file) {
  File& added = files_.emplace_back();
  added.database = open_database(file);
  const auto topics = sql::prepare(added.database, topics_query(added.database));
  while (sql::step(added.database, topics)) {
    const BagTopic topic{sql::text(topics, 1), sql::text(topics, 2),
                         recorded_qos(sql::text(topics, 1), sql::text(topics, 4))};
    check_format(added.database, topic.name, sql::text(topics, 3));
    const auto known = std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& other) {
      return other.name == topic.name && other.type == topic.type;
    });
    added.index[sqlite3_column_int64(topics.get(), 0)] =
        static_cast<std::size_t>(known - topics_.begin());
    if (known == topics_.end()) topics_.push_back(topic);
  }
  const auto first = sql::prepare(added.database, "SELECT MIN(timestamp) FROM messages");
  if (sql::step(added.database, first)) added.first = sqlite3_column_int64(first.get(), 0);
}

bool BagReader::next(BagMessage& message) {
  for (; !files_.empty(); files_.pop_back(), select_.reset()) {
    const File& file = files_.back();
    if (!select_)
      select_ = sql::prepare(
          file.database, "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id");
    while (sql::step(file.database, select_)) {
      // Unknown topic id: the file is damaged, or it is still being written and the topic was added
      // after the file was opened.
      const auto topic = file.index.find(sqlite3_column_int64(select_.get(), 0));
      if (topic == file.index.end()) continue;
      message.topic = topic->second;
      message.time = without_gap(sqlite3_column_int64(select_.get(), 1));
      message.bytes = plain_bytes(file);
      return true;
    }
  }
  return false;
}

// The data of the message in the current row of select_.
std::vector<std::uint8_t> BagReader::plain_bytes(const File& file) const {
  const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(select_.get(), 2));
  const std::span bytes{data, static_cast<std::size_t>(sqlite3_column_bytes(select_.get(), 2))};
  if (!is_zstd(bytes)) return {bytes.begin(), bytes.end()};
  try {
    return decompress(bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.database.name + ": a message is damaged: " + error.what());
  }
}

// Timestamps increase, except where consecutive files overlap by a few nanoseconds.
std::int64_t BagReader::without_gap(std::int64_t stamp) {
  const std::int64_t gap = last_stamp_ ? stamp - *last_stamp_ : 0;
  if (gap > kLongestPause) skipped_ += gap;
  last_stamp_ = stamp;
  return stamp - skipped_;
}

}  // namespace tandem
