// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_results.hpp"

#include <gnu/libc-version.h>
#include <sqlite3.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "bringup/scenario/checksum.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kPatience = 60'000;  // [ms] to wait while other processes write to the file
const std::string kKey = "scenario, method, driver, seed";
const std::string kKeepFirst = " ON CONFLICT(" + kKey + ") DO NOTHING";
const std::string kGroup = "scenario = ? AND method = ? AND driver = ?";
// What is stored beside the measures.
const std::vector<std::string> kBeside{"cost_s", "build", "machine"};

struct Column {
  std::string name;
  json::json_pointer field;  // of a drive's JSON
  json example;              // of its type; null for a measure that may be undefined
};

void add_columns(const json& example, const std::string& prefix, const json::json_pointer& parent,
                 std::vector<Column>& columns) {
  for (const auto& [key, value] : example.items()) {
    if (value.is_object())
      add_columns(value, prefix + key + ".", parent / key, columns);
    else
      columns.push_back({prefix + key, parent / key, value});
  }
}

// The key first, then the measures.
const std::vector<Column>& columns() {
  static const std::vector<Column> all = [] {
    std::vector<Column> columns;
    add_columns(json(DriveResult{}), "", json::json_pointer{}, columns);
    const auto is_key = [](const Column& column) {
      return column.name == "scenario" || column.name == "method" || column.name == "driver" ||
             column.name == "seed";
    };
    std::stable_partition(columns.begin(), columns.end(), is_key);
    return columns;
  }();
  return all;
}

std::string type_of(const Column& column) {
  if (column.example.is_string() || column.example.is_array()) return "TEXT NOT NULL";
  if (column.example.is_null()) return "REAL";
  return column.example.is_number_float() ? "REAL NOT NULL" : "INTEGER NOT NULL";
}

std::string quoted(const std::string& name) { return '"' + name + '"'; }

std::string names() {
  std::string all;
  for (const Column& column : columns()) all += (all.empty() ? "" : ", ") + quoted(column.name);
  return all;
}

// WITHOUT ROWID keeps the rows in the order of the key, so that a group's rows are read in one
// piece.
std::string schema() {
  std::string fields;
  for (const Column& column : columns())
    fields += quoted(column.name) + " " + type_of(column) + ", ";
  return "CREATE TABLE IF NOT EXISTS drives(" + fields +
         "cost_s REAL NOT NULL, build TEXT NOT NULL, machine TEXT NOT NULL, PRIMARY KEY(" + kKey +
         ")) WITHOUT ROWID;"
         "CREATE TABLE IF NOT EXISTS tracks(scenario TEXT NOT NULL, method TEXT NOT NULL,"
         " driver TEXT NOT NULL, seed INTEGER NOT NULL, track TEXT NOT NULL, contacts TEXT NOT "
         "NULL,"
         " PRIMARY KEY(" +
         kKey + ")) WITHOUT ROWID;";
}

std::string questions(std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += i == 0 ? "?" : ", ?";
  return all;
}

void bind_value(const SqliteStatement& statement, int index, const json& value) {
  if (value.is_null())
    sqlite3_bind_null(statement.get(), index);
  else if (value.is_string())
    sql::bind_text(statement, index, value.get<std::string>());
  else if (value.is_number_float())
    sqlite3_bind_double(statement.get(), index, value.get<double>());
  else if (value.is_number() || value.is_boolean())
    sqlite3_bind_int64(statement.get(), index,
                       value.is_boolean() ? int{value.get<bool>()} : value.get<std::int64_t>());
  else
    sql::bind_text(statement, index, value.dump());
}

json value_of(const SqliteStatement& row, int index, const json& example) {
  if (sqlite3_column_type(row.get(), index) == SQLITE_NULL) return nullptr;
  if (example.is_boolean()) return sqlite3_column_int64(row.get(), index) != 0;
  if (example.is_string()) return sql::text(row, index);
  if (example.is_array()) return json::parse(sql::text(row, index));
  if (example.is_number_integer()) return sqlite3_column_int64(row.get(), index);
  return sqlite3_column_double(row.get(), index);
}

void run(const SqliteDatabase& database, const SqliteStatement& statement) {
  (void)sql::step(database, statement);
  sqlite3_reset(statement.get());
}

std::uint64_t checksum_of(const fs::path& file, std::uint64_t sum) {
  std::ifstream in{file, std::ios::binary};
  char part[65536];
  while (in.read(part, sizeof part), in.gcount() > 0)
    sum = checksum({part, static_cast<std::size_t>(in.gcount())}, sum);
  return sum;
}

// Of the program, its runtime library and its modules.
std::string checksum_of_build() {
  std::set<fs::path> files;
  for (const fs::path folder : rt::component_folders()) {
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator{folder, missing})
      if (entry.path().filename().string().starts_with("libtandem")) files.insert(entry.path());
  }
  std::uint64_t sum = checksum_of("/proc/self/exe", checksum({}));
  for (const auto& file : files) sum = checksum_of(file, sum);
  return fmt::format("{:016x}", sum);
}

std::string processor() {
  std::ifstream in{"/proc/cpuinfo"};
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(": ") + 2);
  return "unknown processor";
}

}  // namespace

std::string name_of(const DriveGroup& group) {
  return group.scenario + "/" + group.method + "/" + group.driver;
}

const DriveOrigin& this_origin() {
  static const DriveOrigin origin = [] {
    utsname system{};
    uname(&system);
    return DriveOrigin{checksum_of_build(),
                       fmt::format("{}: {}, {}, glibc {}", system.nodename, processor(),
                                   system.machine, gnu_get_libc_version())};
  }();
  return origin;
}

StudyResults::StudyResults(const std::string& file)
    : database_{create_database(file, "the results of a study")} {
  sqlite3_busy_timeout(database_.handle.get(), kPatience);
  // Larger pages hold more rows, and most tracks.
  sql::execute(database_, "PRAGMA page_size = 16384; PRAGMA cache_size = -8192;" + schema());
  check_columns();
  insert_drive_ = sql::prepare(
      database_, "INSERT INTO drives(" + names() + ", cost_s, build, machine) VALUES (" +
                     questions(columns().size() + kBeside.size()) + ")" + kKeepFirst);
  insert_track_ =
      sql::prepare(database_, "INSERT INTO tracks(" + kKey + ", track, contacts) VALUES (" +
                                  questions(6) + ")" + kKeepFirst);
}

void StudyResults::check_columns() const {
  std::set<std::string> ours{kBeside.begin(), kBeside.end()}, theirs;
  for (const Column& column : columns()) ours.insert(column.name);
  query("SELECT name FROM pragma_table_info('drives')", {},
        [&](const SqliteStatement& row) { theirs.insert(sql::text(row, 0)); });
  if (ours != theirs)
    throw std::runtime_error(database_.name +
                             ": drives of another version of tandem; choose another folder");
}

void StudyResults::add(const json& finished, const DriveOrigin& origin) {
  if (sqlite3_get_autocommit(database_.handle.get()) != 0)
    return add_many([&] { add(finished, origin); });
  int index = 0;
  for (const Column& column : columns())
    bind_value(insert_drive_, ++index, finished.at("drive").at(column.field));
  bind_value(insert_drive_, ++index, finished.at("cost_s"));
  bind_value(insert_drive_, ++index, origin.build);
  bind_value(insert_drive_, ++index, origin.machine);
  run(database_, insert_drive_);
  index = 0;
  for (const char* key : {"scenario", "method", "driver", "seed"})
    bind_value(insert_track_, ++index, finished.at("drive").at(key));
  bind_value(insert_track_, ++index, finished.at("track"));
  bind_value(insert_track_, ++index, finished.at("contacts"));
  run(database_, insert_track_);
}

void StudyResults::add_many(const std::function<void()>& add_them) {
  sql::execute(database_, "BEGIN IMMEDIATE");
  try {
    add_them();
    sql::execute(database_, "COMMIT");
  } catch (...) {
    sqlite3_exec(database_.handle.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

void StudyResults::add_all_of(const StudyResults& other) {
  query("ATTACH ? AS other", {other.database_.name}, [](const auto&) {});
  const std::string all = names() + ", cost_s, build, machine";
  add_many([&] {
    sql::execute(database_, "INSERT INTO main.drives(" + all + ") SELECT " + all +
                                " FROM other.drives WHERE true" + kKeepFirst +
                                ";INSERT INTO main.tracks SELECT * FROM other.tracks WHERE true" +
                                kKeepFirst);
  });
  sql::execute(database_, "DETACH other");
}

bool StudyResults::contains(const DriveGroup& group, unsigned seed) const {
  bool found = false;
  query("SELECT 1 FROM drives WHERE " + kGroup + " AND seed = " + std::to_string(seed),
        {group.scenario, group.method, group.driver}, [&](const auto&) { found = true; });
  return found;
}

std::size_t StudyResults::size() const {
  std::size_t count = 0;
  query("SELECT count(*) FROM drives", {}, [&](const SqliteStatement& row) {
    count = static_cast<std::size_t>(sqlite3_column_int64(row.get(), 0));
  });
  return count;
}

double StudyResults::cost() const {
  double cost = 0.0;
  query("SELECT sum(cost_s) FROM drives", {},
        [&](const SqliteStatement& row) { cost = sqlite3_column_double(row.get(), 0); });
  return cost;
}

void StudyResults::select(const DriveGroup& group, const std::string& columns,
                          const Row& row) const {
  query("SELECT " + columns + " FROM drives WHERE " + kGroup + " ORDER BY seed",
        {group.scenario, group.method, group.driver}, row);
}

void StudyResults::query(const std::string& sql, const std::vector<std::string>& bound,
                         const Row& row) const {
  const auto statement = sql::prepare(database_, sql);
  for (std::size_t i = 0; i < bound.size(); ++i)
    sql::bind_text(statement, static_cast<int>(i) + 1, bound[i]);
  while (sql::step(database_, statement)) row(statement);
}

void StudyResults::read(const DriveGroup& group,
                        const std::function<void(const DriveResult&)>& use) const {
  select(group, names(), [&](const SqliteStatement& row) {
    json drive;
    int index = 0;
    for (const Column& column : columns())
      drive[column.field] = value_of(row, index++, column.example);
    use(drive.get<DriveResult>());
  });
}

}  // namespace tandem
