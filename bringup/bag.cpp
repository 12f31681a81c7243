// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr int kMetadataVersion = 5, kSchemaVersion = 3;  // Humble's
constexpr const char* kMetadataFile = "metadata.yaml";
constexpr int kBusy = 1000;  // [ms] to wait for another who has the file

// rmw's numbers for policies.
constexpr int kKeepLast = 1, kReliable = 1, kBestEffort = 2, kTransientLocal = 1, kVolatile = 2,
              kAutomatic = 1;

using Database = std::shared_ptr<sqlite3>;
using Statement = std::shared_ptr<sqlite3_stmt>;

std::string mend(int result, const std::string& file) {
  switch (result) {
    case SQLITE_CORRUPT:  // it was cut off, or a sector of it is lost
      return "; save what is left of it: sqlite3 " + file + " .recover | sqlite3 saved.db3";
    case SQLITE_NOTADB:
    case SQLITE_ERROR:  // no such table
      return "; is it a recording, and of storage sqlite3, not mcap?";
    case SQLITE_FULL:
      return "; make room on the disk";
    default:
      return "";
  }
}

[[noreturn]] void fail(const Database& database, const std::string& file) {
  throw std::runtime_error(file + ": " + sqlite3_errmsg(database.get()) +
                           mend(sqlite3_errcode(database.get()), file));
}

Database open(const std::string& file, int flags) {
  sqlite3* raw = nullptr;
  const int result = sqlite3_open_v2(file.c_str(), &raw, flags, nullptr);
  Database database{raw, sqlite3_close};
  if (result != SQLITE_OK) fail(database, file);
  sqlite3_busy_timeout(raw, kBusy);
  return database;
}

std::string file_of(const Database& database) {
  return sqlite3_db_filename(database.get(), "main");
}

Statement prepare(const Database& database, const std::string& sql) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database.get(), sql.c_str(), -1, &raw, nullptr) != SQLITE_OK)
    fail(database, file_of(database));
  // The statement keeps its database open.
  return {raw, [database](sqlite3_stmt* statement) { sqlite3_finalize(statement); }};
}

void execute(const Database& database, const std::string& sql) {
  if (sqlite3_exec(database.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    fail(database, file_of(database));
}

// False after the last row.
bool step(const Database& database, const Statement& statement) {
  const int result = sqlite3_step(statement.get());
  if (result != SQLITE_ROW && result != SQLITE_DONE) fail(database, file_of(database));
  return result == SQLITE_ROW;
}

std::string text(const Statement& row, int column) {
  const auto* chars = reinterpret_cast<const char*>(sqlite3_column_text(row.get(), column));
  return chars == nullptr ? "" : chars;
}

void bind_text(const Statement& statement, int index, const std::string& value) {
  sqlite3_bind_text(statement.get(), index, value.data(), static_cast<int>(value.size()),
                    SQLITE_TRANSIENT);
}

void emit_duration(YAML::Emitter& out, const char* name) {
  out << YAML::Key << name << YAML::Value << YAML::BeginMap;  // none, as rmw writes it
  out << YAML::Key << "sec" << YAML::Value << 9223372036 << YAML::Key << "nsec" << YAML::Value
      << 854775807 << YAML::EndMap;
}

std::string qos_yaml(const rt::QoS& qos) {
  const bool reliable = qos.reliability == rt::Reliability::kReliable;
  const bool latched = qos.durability == rt::Durability::kTransientLocal;
  YAML::Emitter out;
  out << YAML::BeginSeq << YAML::BeginMap;
  out << YAML::Key << "history" << YAML::Value << kKeepLast;
  out << YAML::Key << "depth" << YAML::Value << qos.depth;
  out << YAML::Key << "reliability" << YAML::Value << (reliable ? kReliable : kBestEffort);
  out << YAML::Key << "durability" << YAML::Value << (latched ? kTransientLocal : kVolatile);
  emit_duration(out, "deadline");
  emit_duration(out, "lifespan");
  out << YAML::Key << "liveliness" << YAML::Value << kAutomatic;
  emit_duration(out, "liveliness_lease_duration");
  out << YAML::Key << "avoid_ros_namespace_conventions" << YAML::Value << false;
  out << YAML::EndMap << YAML::EndSeq;
  return out.c_str();
}

// Humble writes numbers, Jazzy words.
bool is(const YAML::Node& value, int number, const char* word) {
  return value &&
         (value.as<std::string>() == std::to_string(number) || value.as<std::string>() == word);
}

// The default profile where a recording says nothing that can be read.
rt::QoS qos_from(const std::string& yaml) {
  rt::QoS qos;
  try {
    const YAML::Node profiles = YAML::Load(yaml);
    if (!profiles.IsSequence() || profiles.size() == 0) return qos;
    const YAML::Node profile = profiles[0];
    if (is(profile["reliability"], kBestEffort, "best_effort"))
      qos.reliability = rt::Reliability::kBestEffort;
    if (is(profile["durability"], kTransientLocal, "transient_local"))
      qos.durability = rt::Durability::kTransientLocal;
    if (profile["depth"]) qos.depth = std::clamp(profile["depth"].as<int>(), 1, 10'000);
  } catch (const YAML::Exception&) {
  }
  return qos;
}

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

std::vector<std::string> databases_in(const std::string& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator{path})
    if (entry.path().extension() == ".db3") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (!files.empty()) return files;
  throw std::runtime_error(path +
                           " holds no .db3: is it a recording, and of storage sqlite3, not mcap?");
}

}  // namespace

BagWriter::BagWriter(const std::string& folder) : folder_{folder} {
  if (fs::exists(folder)) throw std::runtime_error(folder + " exists already");
  fs::create_directories(folder);
  const fs::path path{folder};
  const std::string stem = path.has_filename() ? path.filename() : path.parent_path().filename();
  file_ = stem + "_0.db3";
  database_ = open(path / file_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  // With a log beside it the file can be read while it is written.
  execute(database_,
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
  insert_ = prepare(database_, "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)");
  write_metadata();
}

BagWriter::~BagWriter() {
  try {
    commit();
    insert_.reset();
    execute(database_, "COMMIT; PRAGMA journal_mode=DELETE");  // one file is all that stays
  } catch (const std::exception&) {  // said before, or the disk is full: nothing more to do
  }
}

int BagWriter::add_topic(const BagTopic& topic) {
  const auto statement =
      prepare(database_,
              "INSERT INTO topics (name, type, serialization_format, offered_qos_profiles)"
              " VALUES (?, ?, 'cdr', ?)");
  bind_text(statement, 1, topic.name);
  bind_text(statement, 2, topic.type);
  bind_text(statement, 3, qos_yaml(topic.qos));
  if (sqlite3_step(statement.get()) != SQLITE_DONE) fail(database_, file_);
  const int id = static_cast<int>(sqlite3_last_insert_rowid(database_.get()));
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
  if (result != SQLITE_DONE) fail(database_, file_);
  if (messages_++ == 0) first_ = last_ = time;
  first_ = std::min(first_, time);
  last_ = std::max(last_, time);
  ++topics_.at(topic).messages;
}

void BagWriter::commit() {
  execute(database_, "COMMIT; BEGIN");
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
  fs::rename(fresh, path);  // never half of it
}

BagReader::BagReader(const std::string& path) {
  for (const auto& file : databases_in(path)) add(file);
  std::stable_sort(files_.begin(), files_.end(),
                   [](const File& a, const File& b) { return a.first > b.first; });
}

void BagReader::add(const std::string& file) {
  File& added = files_.emplace_back();
  added.database = open(file, SQLITE_OPEN_READONLY);
  const auto topics = prepare(
      added.database, "SELECT name, type, offered_qos_profiles, id FROM topics ORDER BY id");
  while (step(added.database, topics)) {
    const BagTopic topic{text(topics, 0), text(topics, 1), qos_from(text(topics, 2))};
    const auto known = std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& other) {
      return other.name == topic.name && other.type == topic.type;
    });
    added.index[sqlite3_column_int64(topics.get(), 3)] =
        static_cast<std::size_t>(known - topics_.begin());
    if (known == topics_.end()) topics_.push_back(topic);
  }
  const auto first = prepare(added.database, "SELECT MIN(timestamp) FROM messages");
  if (step(added.database, first)) added.first = sqlite3_column_int64(first.get(), 0);
}

bool BagReader::next(BagMessage& message) {
  for (; !files_.empty(); files_.pop_back(), select_.reset()) {
    const File& file = files_.back();
    if (!select_)
      select_ = prepare(file.database,
                        "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id");
    while (step(file.database, select_)) {
      // A file that is damaged has messages of no topic, one that is still written of topics that
      // came after it was opened.
      const auto topic = file.index.find(sqlite3_column_int64(select_.get(), 0));
      if (topic == file.index.end()) continue;
      message.topic = topic->second;
      message.time = sqlite3_column_int64(select_.get(), 1);
      const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(select_.get(), 2));
      const int size = sqlite3_column_bytes(select_.get(), 2);
      message.bytes.assign(data, data + size);
      return true;
    }
  }
  return false;
}

}  // namespace tandem
