// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/bag_database.hpp"

#include <sqlite3.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "bringup/bag/zstd.hpp"

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
      return "; is it a recording stored as sqlite3 rather than mcap? If it is mcap," +
             how_to_convert(file);
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

// A temporary folder, removed with its contents at the end of the scope.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_{fs::temp_directory_path() / "tandem_bag_XXXXXX"} {
    std::string name = path_.string();
    if (mkdtemp(name.data()) == nullptr)
      throw std::runtime_error(name + ": cannot be created; choose another folder with TMPDIR");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// The decompressed file is unlinked once it is open. Nothing writes to it, so SQLite needs neither
// locks nor a write-ahead log.
BagDatabase open_compressed(const std::string& file) {
  const TemporaryFolder folder;
  const fs::path plain = folder.path() / "plain.db3";
  try {
    decompress_file(file, plain);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file + ": " + error.what());
  }
  return open(uri_of(plain) + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, file);
}

}  // namespace

std::string how_to_convert(const std::string& path) {
  return " convert it: ros2 bag convert -i " + path +
         " -o out.yaml, where out.yaml holds output_bags: [{uri: converted, storage_id: sqlite3, "
         "all: true, rmw_serialization_format: cdr}]";
}

BagDatabase create_database(const std::string& file) {
  return open(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, file);
}

BagDatabase open_database(const std::string& file) {
  return file.ends_with(kCompressedDatabase) ? open_compressed(file)
                                             : open(file, SQLITE_OPEN_READONLY, file);
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
