// SPDX-License-Identifier: Apache-2.0
// Opens a recording's SQLite files and runs statements on them. All functions throw
// std::runtime_error naming the file; the message explains how to repair it.
#pragma once

#include <memory>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace tandem {

/// An open database and the name that error messages use for it.
struct BagDatabase {
  std::shared_ptr<sqlite3> handle = {};
  std::string name = {};
};

using BagStatement = std::shared_ptr<sqlite3_stmt>;

[[nodiscard]] BagDatabase create_database(const std::string& file);

/// Opens a file for reading. `name`: for messages. `is_temporary`: nothing else uses the file,
/// which may be removed once it is open.
[[nodiscard]] BagDatabase open_database(const std::string& file, const std::string& name,
                                        bool is_temporary);

namespace sql {

/// Throws SQLite's last error message together with how to repair the file.
[[noreturn]] void fail(const BagDatabase& database);

[[nodiscard]] BagStatement prepare(const BagDatabase& database, const std::string& sql);
void execute(const BagDatabase& database, const std::string& sql);
/// False after the last row.
bool step(const BagDatabase& database, const BagStatement& statement);
[[nodiscard]] std::string text(const BagStatement& row, int column);
void bind_text(const BagStatement& statement, int index, const std::string& value);

}  // namespace sql
}  // namespace tandem
