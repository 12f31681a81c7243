// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/bag_database.hpp"

#include <sqlite3.h>

#include <filesystem>
#include <stdexcept>

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr int kBusy = 1000;  // [ms] to wait for another process's lock on the file

std::string mend(int result, const std::string& file) {
  switch (result) {
    case SQLITE_CORRUPT:  // truncated, or a sector is lost
      return "; recover what is left of it: sqlite3 " + file + " .recover | sqlite3 saved.db3";
    case SQLITE_NOTADB:
    case SQLITE_ERROR:  // no such table
      return "; is it a recording, stored as mcap or sqlite3?";
    case SQLITE_FULL:
      return "; free some disk space";
    default:
      return "";
  }
}

// `file` may be an SQLite URI; error messages use `name`.
BagDatabase open(const std::string& file, int flags, const std::string& name) {
  sqlite3* raw = nullptr;
  const int result = sqlite3_open_v2(file.c_str(), &raw, flags, nullptr);
  BagDatabase database{{raw, sqlite3_close}, name};
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

BagDatabase create_database(const std::string& file) {
  return open(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, file);
}

BagDatabase open_database(const std::string& file, const std::string& name, bool is_temporary) {
  // Nothing writes to a temporary file, so SQLite needs neither locks nor a write-ahead log.
  return is_temporary
             ? open(uri_of(file) + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, name)
             : open(file, SQLITE_OPEN_READONLY, name);
}

namespace sql {

void fail(const BagDatabase& database) {
  throw std::runtime_error(database.name + ": " + sqlite3_errmsg(database.handle.get()) +
                           mend(sqlite3_errcode(database.handle.get()), database.name));
}

BagStatement prepare(const BagDatabase& database, const std::string& sql) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database.handle.get(), sql.c_str(), -1, &raw, nullptr) != SQLITE_OK)
    fail(database);
  // The statement shares ownership of its database.
  return {raw, [database](sqlite3_stmt* statement) { sqlite3_finalize(statement); }};
}

void execute(const BagDatabase& database, const std::string& sql) {
  if (sqlite3_exec(database.handle.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    fail(database);
}

bool step(const BagDatabase& database, const BagStatement& statement) {
  const int result = sqlite3_step(statement.get());
  if (result != SQLITE_ROW && result != SQLITE_DONE) fail(database);
  return result == SQLITE_ROW;
}

std::string text(const BagStatement& row, int column) {
  const auto* chars = reinterpret_cast<const char*>(sqlite3_column_text(row.get(), column));
  return chars == nullptr ? "" : chars;
}

void bind_text(const BagStatement& statement, int index, const std::string& value) {
  sqlite3_bind_text(statement.get(), index, value.data(), static_cast<int>(value.size()),
                    SQLITE_TRANSIENT);
}

}  // namespace sql
}  // namespace tandem
