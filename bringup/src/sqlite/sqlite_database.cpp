// SPDX-License-Identifier: Apache-2.0
#include "bringup/sqlite/sqlite_database.hpp"

#include <sqlite3.h>

#include <filesystem>
#include <stdexcept>

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr int kBusy = 1000;  // [ms] to wait for another process's lock on the file

std::string mend(int result, const SqliteDatabase& database) {
  switch (result) {
    case SQLITE_CORRUPT:  // truncated, or a sector is lost
      return "; recover what is left of it: sqlite3 " + database.name +
             " .recover | sqlite3 saved.db3";
    case SQLITE_NOTADB:
    case SQLITE_ERROR:  // no such table
      return "; is it " + database.content + "?";
    case SQLITE_FULL:
      return "; free some disk space";
    default:
      return "";
  }
}

// `path` may be an SQLite URI; error messages use `name`.
SqliteDatabase open(const std::string& path, int flags, const std::string& name,
                    const std::string& content) {
  sqlite3* raw = nullptr;
  const int result = sqlite3_open_v2(path.c_str(), &raw, flags, nullptr);
  SqliteDatabase database{{raw, sqlite3_close}, name, content};
  if (result != SQLITE_OK) sql::fail(database);
  sqlite3_busy_timeout(raw, kBusy);
  return database;
}

std::string uri_of(const fs::path& file) {
  std::string uri = "file:";
  for (const char c : fs::absolute(file).string())
    uri += c == '%' ? "%25" : c == '?' ? "%3f" : c == '#' ? "%23" : std::string(1, c);
  return uri;
}

}  // namespace

SqliteDatabase create_database(const std::string& file, const std::string& content) {
  return open(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, file, content);
}

SqliteDatabase open_database(const SqliteFile& file, const std::string& content) {
  // Nothing writes to a temporary file, so SQLite needs neither locks nor a write-ahead log.
  return file.is_temporary ? open(uri_of(file.path) + "?immutable=1",
                                  SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, file.name, content)
                           : open(file.path, SQLITE_OPEN_READONLY, file.name, content);
}

namespace sql {

void fail(const SqliteDatabase& database) {
  throw std::runtime_error(database.name + ": " + sqlite3_errmsg(database.handle.get()) +
                           mend(sqlite3_errcode(database.handle.get()), database));
}

SqliteStatement prepare(const SqliteDatabase& database, const std::string& sql) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database.handle.get(), sql.c_str(), -1, &raw, nullptr) != SQLITE_OK)
    fail(database);
  // The statement shares ownership of its database.
  return {raw, [database](sqlite3_stmt* statement) { sqlite3_finalize(statement); }};
}

void execute(const SqliteDatabase& database, const std::string& sql) {
  if (sqlite3_exec(database.handle.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    fail(database);
}

bool step(const SqliteDatabase& database, const SqliteStatement& statement) {
  const int result = sqlite3_step(statement.get());
  if (result != SQLITE_ROW && result != SQLITE_DONE) fail(database);
  return result == SQLITE_ROW;
}

std::string text(const SqliteStatement& row, int column) {
  const auto* chars = reinterpret_cast<const char*>(sqlite3_column_text(row.get(), column));
  return chars == nullptr ? "" : chars;
}

void bind_text(const SqliteStatement& statement, int index, const std::string& value) {
  sqlite3_bind_text(statement.get(), index, value.data(), static_cast<int>(value.size()),
                    SQLITE_TRANSIENT);
}

}  // namespace sql
}  // namespace tandem
