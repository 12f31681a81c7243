// SPDX-License-Identifier: Apache-2.0
// Opens SQLite files and runs statements on them. All functions throw std::runtime_error naming the
// file; the message explains how to repair it.
#pragma once

#include <memory>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace tandem {

/// An open database, and what error messages say about it.
struct SqliteDatabase {
  std::shared_ptr<sqlite3> handle = {};
  std::string name = {};
  std::string content = {};  ///< what the file should be, as "a recording"
};

using SqliteStatement = std::shared_ptr<sqlite3_stmt>;

/// Opens a file for reading and writing, and creates it if there is none.
[[nodiscard]] SqliteDatabase create_database(const std::string& file, const std::string& content);

/// A file to read. `is_temporary`: nothing else uses the file, which may be removed once it is
/// open.
struct SqliteFile {
  std::string path, name;  ///< `name`: for messages
  bool is_temporary = false;
};
[[nodiscard]] SqliteDatabase open_database(const SqliteFile& file, const std::string& content);

namespace sql {

/// Throws SQLite's last error message together with how to repair the file.
[[noreturn]] void fail(const SqliteDatabase& database);

[[nodiscard]] SqliteStatement prepare(const SqliteDatabase& database, const std::string& sql);
void execute(const SqliteDatabase& database, const std::string& sql);
/// False after the last row.
bool step(const SqliteDatabase& database, const SqliteStatement& statement);
[[nodiscard]] std::string text(const SqliteStatement& row, int column);
void bind_text(const SqliteStatement& statement, int index, const std::string& value);

}  // namespace sql
}  // namespace tandem
