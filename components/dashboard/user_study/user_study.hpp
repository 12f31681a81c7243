// SPDX-License-Identifier: Apache-2.0
// Saves the results of user tests, sent by the page, to files on the robot's side.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// One drive of Devalla's user test (2020, §4.2): task 1, driving freely for a time; task 2,
/// driving to the region.
struct UserTrial {
  std::string method;  ///< policy of arbitration: "manual", "shared", …
  int task = 1;
  bool practice = false;
  double allowed = 0.0;  ///< [s] time limit
  double time = 0.0;     ///< [s] time taken
  bool reached = false;  ///< task 2: the region was reached
  int collisions = 0;
  double min_clearance = 0.0;  ///< [m]
  double path_length = 0.0;    ///< [m]
};

/// A participant is identified only by a number that they or the experimenter choose.
struct UserStudy {
  int person = 0;
  std::vector<UserTrial> trials;
};

void to_json(nlohmann::json& json, const UserTrial& trial);
/// Parses the request of a trial, without results: `method`, `task`, `practice` and `allowed`.
/// Throws std::invalid_argument for invalid values, and nlohmann's exceptions.
[[nodiscard]] UserTrial parse_trial_asked(const nlohmann::json& json);

/// Throws std::invalid_argument for a malformed user test, including numbers out of range.
[[nodiscard]] UserStudy parse_user_study(std::string_view json);

/// One CSV line per trial, after a header line if `heading`.
[[nodiscard]] std::string to_csv(const UserStudy& test, bool heading);

/// Writes user_test_<k>.json, with the first free number k, and appends to user_tests.csv in the
/// folder. Returns the JSON file's path. Throws std::runtime_error if it cannot write.
[[nodiscard]] std::filesystem::path save(const UserStudy& test,
                                         const std::filesystem::path& folder);

}  // namespace tandem
