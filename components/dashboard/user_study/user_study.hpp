// SPDX-License-Identifier: Apache-2.0
// In: what a page says of a person's test. Out: files on the robot's side.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// One drive of Devalla's user test (2020, §4.2): task 1, for a time at will; task 2, to the
/// region.
struct UserTrial {
  std::string method;  ///< policy of arbitration: "manual", "shared", …
  int task = 1;
  bool practice = false;
  double allowed = 0.0;  ///< [s] longest that it could take
  double time = 0.0;     ///< [s] that it took
  bool reached = false;  ///< task 2: the region
  int collisions = 0;
  double min_clearance = 0.0;  ///< [m]
  double path_length = 0.0;    ///< [m]
};

/// A person is a number that they or the experimenter choose; nothing else is known of them.
struct UserStudy {
  int person = 0;
  std::vector<UserTrial> trials;
};

void to_json(nlohmann::json& json, const UserTrial& trial);
/// What was asked for, without what came of it: `method`, `task`, `practice` and `allowed`. Throws
/// std::invalid_argument for what is none, and nlohmann's exceptions.
[[nodiscard]] UserTrial parse_trial_asked(const nlohmann::json& json);

/// Throws std::invalid_argument for what is no user test, numbers out of reason included.
[[nodiscard]] UserStudy parse_user_study(std::string_view json);

/// One line per trial, a heading first if `heading`.
[[nodiscard]] std::string to_csv(const UserStudy& test, bool heading);

/// Writes user_test_<k>.json, k the first number that is free, and appends to user_tests.csv in
/// the folder; gives back the JSON file's path. Throws std::runtime_error if it cannot.
[[nodiscard]] std::filesystem::path save(const UserStudy& test,
                                         const std::filesystem::path& folder);

}  // namespace tandem
