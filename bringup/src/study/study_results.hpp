// SPDX-License-Identifier: Apache-2.0
// Stores the finished drives of a study in an SQLite file, from which they are read one by one.
#pragma once

#include <compare>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bringup/sqlite/sqlite_database.hpp"
#include "tandem/metrics/metrics.hpp"

namespace tandem {

/// The drives of one scenario with one method and one driver.
struct DriveGroup {
  std::string scenario, method, driver;
  friend auto operator<=>(const DriveGroup&, const DriveGroup&) = default;
};

/// "SCENARIO/METHOD/DRIVER".
[[nodiscard]] std::string name_of(const DriveGroup& group);

/// What drove a drive. Drives of two builds may differ.
struct DriveOrigin {
  std::string build;    ///< checksum of the program and its components
  std::string machine;  ///< host, processor and C library
  friend auto operator<=>(const DriveOrigin&, const DriveOrigin&) = default;
};

/// This program on this machine.
[[nodiscard]] const DriveOrigin& this_origin();

/// The file drives.sqlite of a study's folder:
///
///   drives   a row per drive: its measures, a column for each field of DriveResult, nested ones
///            named `outer.inner`; cost_s; build and machine. Ordered by its key (scenario, method,
///            driver, seed).
///   tracks   the same key; track and contacts as JSON
///
/// Several processes may write at the same time, even the same drive: the first to store it wins.
/// All functions throw std::runtime_error, which names the file, if it is damaged or cannot be
/// written.
class StudyResults {
 public:
  using Row = std::function<void(const SqliteStatement&)>;

  /// Opens the file, and creates it if there is none. Throws std::runtime_error if it has the
  /// columns of another version of Tandem.
  explicit StudyResults(const std::string& file);

  /// Stores a finished drive {"drive": …, "track": …, "contacts": …, "cost_s": …}; it is on the
  /// disk before this returns. A drive that is stored already is kept.
  void add(const nlohmann::json& finished, const DriveOrigin& origin = this_origin());
  /// Stores many drives faster: `add_them` calls add(), and all are on the disk when this returns.
  void add_many(const std::function<void()>& add_them);
  /// Adds the drives of another such file that this one lacks.
  void add_all_of(const StudyResults& other);

  [[nodiscard]] bool contains(const DriveGroup& group, unsigned seed) const;
  [[nodiscard]] std::size_t size() const;
  /// CPU time that the drives cost [s].
  [[nodiscard]] double cost() const;
  /// Calls `row` with each row of `SELECT columns FROM drives` of a group, in the order of seeds.
  void select(const DriveGroup& group, const std::string& columns, const Row& row) const;
  /// Calls `row` with each row of any query. `bound`: the values of its question marks.
  void query(const std::string& sql, const std::vector<std::string>& bound, const Row& row) const;
  /// Calls `use` with each drive of a group, in the order of seeds.
  void read(const DriveGroup& group, const std::function<void(const DriveResult&)>& use) const;

 private:
  void check_columns() const;

  SqliteDatabase database_;
  SqliteStatement insert_drive_, insert_track_;
};

}  // namespace tandem
