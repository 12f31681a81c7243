// SPDX-License-Identifier: Apache-2.0
// In: finished drives of a study. Out: a folder that keeps them, whatever happens.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bringup/study/study.hpp"

namespace tandem {

/// What the drives of a study leave behind:
///
///   study.json    what the study is, and its drives' names in order
///   drives.jsonl  a line for each finished drive, in the order in which they finished, with the
///                 build of tandem that made it: drives of two builds may differ
///
/// A line is on the disk before append() returns; a last line that was torn by a crash is dropped
/// by the next one who opens the folder. One process at a time.
class StudyFolder {
 public:
  /// Opens a folder, made if need be, for a study. Throws std::invalid_argument if it holds
  /// another study, std::runtime_error if it cannot be written or another process has it open.
  StudyFolder(const std::string& folder, const nlohmann::json& study);
  ~StudyFolder();
  StudyFolder(const StudyFolder&) = delete;
  StudyFolder& operator=(const StudyFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return folder_; }
  /// Lines of finished drives by name.
  [[nodiscard]] const std::map<std::string, nlohmann::json>& finished() const { return finished_; }
  /// Finished drives in the study's order.
  [[nodiscard]] std::vector<DriveResult> results() const;
  /// How many drives each build made; of "" those that do not say.
  [[nodiscard]] std::map<std::string, std::size_t> builds() const;
  /// Keeps a finished drive, as one of this build unless the line says another. Throws
  /// std::runtime_error if the disk takes no more.
  void append(const std::string& name, nlohmann::json line);

 private:
  void claim(const nlohmann::json& study);
  void read_back();

  std::string folder_;
  std::vector<std::string> order_;
  std::map<std::string, nlohmann::json> finished_;
  int file_ = -1;
};

/// Tells one build of this program from another: a checksum of the executable.
[[nodiscard]] const std::string& this_build();

/// What study.json says of a study.
[[nodiscard]] nlohmann::json contents_of(const Study& study);

/// The study.json of a folder. Throws std::runtime_error naming it if it is none.
[[nodiscard]] nlohmann::json read_study(const std::string& folder);

/// Writes a file of a folder at once or not at all. Throws std::runtime_error naming it.
void write_file(const std::string& file, const std::string& text);

}  // namespace tandem
