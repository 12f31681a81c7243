// SPDX-License-Identifier: Apache-2.0
// The folder of a study: which drives it has, and those that are finished.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bringup/study/study.hpp"
#include "bringup/study/study_results.hpp"

namespace tandem {

/// The drives that a study has of a group.
struct PlannedGroup {
  DriveGroup group;
  std::vector<unsigned> seeds;  ///< ascending
};

/// The folder of a study:
///
///   study.json     name and description of the study, and its drives: seeds by scenario, method
///                  and driver
///   drives.sqlite  the finished drives; see StudyResults
///
/// Several processes may write to one folder; see StudyResults.
class StudyFolder {
 public:
  /// Opens the folder of a study and creates it if necessary. Throws std::invalid_argument if it
  /// contains another study, std::runtime_error if it cannot be written, is damaged, or was written
  /// by a Tandem that kept drives in another form.
  StudyFolder(const std::string& folder, const nlohmann::json& study);

  [[nodiscard]] const std::string& path() const { return folder_; }
  /// In the study's order.
  [[nodiscard]] const std::vector<PlannedGroup>& groups() const { return groups_; }
  /// Number of the study's drives, finished or not.
  [[nodiscard]] std::size_t planned() const;
  [[nodiscard]] StudyResults& results() { return results_; }
  [[nodiscard]] const StudyResults& results() const { return results_; }

 private:
  std::string folder_;
  std::vector<PlannedGroup> groups_;
  StudyResults results_;
};

/// The group of a study's drive.
[[nodiscard]] DriveGroup group_of(const Study& study, const StudyDrive& drive);

/// The contents of study.json for a study.
[[nodiscard]] nlohmann::json contents_of(const Study& study);

/// Reads the study.json of a folder. Throws std::runtime_error naming the file if it is missing or
/// damaged.
[[nodiscard]] nlohmann::json read_study(const std::string& folder);

/// The first key in which two descriptions of studies differ.
[[nodiscard]] std::string first_difference(const nlohmann::json& kept, const nlohmann::json& asked);

/// Ascending seeds as text, "1-20,25", and back. The latter throws std::invalid_argument.
[[nodiscard]] std::string seed_ranges(const std::vector<unsigned>& seeds);
[[nodiscard]] std::vector<unsigned> seeds_in(const std::string& ranges);

/// Writes a file atomically. Throws std::runtime_error naming it.
void write_file(const std::string& file, const std::string& text);

}  // namespace tandem
