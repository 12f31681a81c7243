// SPDX-License-Identifier: Apache-2.0
// The SQLite files of a recording: opening, statements and errors that say how to mend them. All of
// these throw std::runtime_error naming the file.
#pragma once

#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace tandem {

/// How the name of a file ends that rosbag2 compressed whole.
inline constexpr std::string_view kCompressedDatabase = ".db3.zstd";

/// An open file, by the name under which errors mention it.
struct BagDatabase {
  std::shared_ptr<sqlite3> handle = {};
  std::string name = {};
};

using BagStatement = std::shared_ptr<sqlite3_stmt>;

/// The command that makes a readable recording of this one, as the end of a sentence.
[[nodiscard]] std::string how_to_convert(const std::string& path);

[[nodiscard]] BagDatabase create_database(const std::string& file);

/// To read. A compressed file is decompressed into the folder for temporary files, and gone from
/// there with the last user of the database.
[[nodiscard]] BagDatabase open_database(const std::string& file);

namespace sql {

/// Throws what SQLite says of its last error there, and how to mend it.
[[noreturn]] void fail(const BagDatabase& database);

[[nodiscard]] BagStatement prepare(const BagDatabase& database, const std::string& sql);
void execute(const BagDatabase& database, const std::string& sql);
/// False after the last row.
bool step(const BagDatabase& database, const BagStatement& statement);
[[nodiscard]] std::string text(const BagStatement& row, int column);
void bind_text(const BagStatement& statement, int index, const std::string& value);

}  // namespace sql
}  // namespace tandem
