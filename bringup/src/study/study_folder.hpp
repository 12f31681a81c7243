// SPDX-License-Identifier: Apache-2.0
// Stores the finished drives of a study in a folder so that a crash loses none of them.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bringup/study/study.hpp"

namespace tandem {

/// The folder of a study:
///
///   study.json    name and description of the study, and its drives' names in order
///   drives.jsonl  a line for each finished drive, in the order of finishing, with the build of
///                 tandem that ran it, because drives of two builds may differ
///
/// A line is on the disk before append() returns. An incomplete last line, left by a crash, is
/// dropped when the folder is opened again. Only one process at a time may open a folder.
class StudyFolder {
 public:
  /// Opens the folder of a study and creates it if necessary. Throws std::invalid_argument if it
  /// contains another study, std::runtime_error if it cannot be written, is damaged, or is open in
  /// another process.
  StudyFolder(const std::string& folder, const nlohmann::json& study);
  ~StudyFolder();
  StudyFolder(const StudyFolder&) = delete;
  StudyFolder& operator=(const StudyFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return folder_; }
  /// Lines of the finished drives, by name of the drive.
  [[nodiscard]] const std::map<std::string, nlohmann::json>& finished() const { return finished_; }
  /// Finished drives in the study's order.
  [[nodiscard]] std::vector<DriveResult> results() const;
  /// Number of finished drives per build; "" counts lines that name no build.
  [[nodiscard]] std::map<std::string, std::size_t> builds() const;
  /// Stores a finished drive, with this build unless the line names another. Throws
  /// std::runtime_error if the file cannot be written, for example on a full disk.
  void append(const std::string& name, nlohmann::json line);

 private:
  void claim(const nlohmann::json& study);
  void read_back();

  std::string folder_;
  std::vector<std::string> order_;
  std::map<std::string, nlohmann::json> finished_;
  int file_ = -1;
};

/// Identifies the build of this program by a checksum of the executable.
[[nodiscard]] const std::string& this_build();

/// The contents of study.json for a study.
[[nodiscard]] nlohmann::json contents_of(const Study& study);

/// Reads the study.json of a folder. Throws std::runtime_error naming the file if it is missing or
/// damaged.
[[nodiscard]] nlohmann::json read_study(const std::string& folder);

/// Writes a file atomically. Throws std::runtime_error naming it.
void write_file(const std::string& file, const std::string& text);

}  // namespace tandem
