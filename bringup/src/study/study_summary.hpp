// SPDX-License-Identifier: Apache-2.0
// Summarizes the measures of many drives: medians, shares, tables and CSV.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bringup/study/study_folder.hpp"

namespace tandem {

/// A value and its 95 % confidence interval.
struct Estimate {
  double value = 0.0, low = 0.0, high = 0.0;
};

/// Median (nearest rank) with the percentile interval of the bootstrap, computed without
/// resampling: the median of a resample is at most the k-th of the n sorted values with the
/// probability that at least ⌈n/2⌉ of n draws fall on the first k, which is binomial (Efron 1979,
/// §3). Empty without values.
[[nodiscard]] std::optional<Estimate> median_of(std::vector<double> values);

/// Share `part` / `whole` with the score interval of Wilson 1927. Empty if `whole` is 0.
[[nodiscard]] std::optional<Estimate> share_of(long part, long whole);

/// An object per group with finished drives: scenario, method, driver, n, seeds; numbers and shares
/// of drives that reached the goal or collided; sums of collisions and of the counters of planner
/// and filter; and the median of each measure over the drives that define it. Holds one measure of
/// one group in memory at a time.
[[nodiscard]] nlohmann::json summary_of(const StudyFolder& folder);

/// A row per group of a summary, for a terminal.
[[nodiscard]] std::string study_table(const nlohmann::json& summary);

/// A row per method: simulated time, CPU time, their ratio, and each part's share of the wall time.
[[nodiscard]] std::string cost_table(const StudyFolder& folder);

/// The drives as CSV (RFC 4180), one row each. Columns are the keys of the JSON, with nested keys
/// as `outer.inner`; undefined values are empty.
[[nodiscard]] std::string csv_of(const StudyFolder& folder);
/// The drives as a JSON array.
[[nodiscard]] std::string json_of(const StudyFolder& folder);

/// What drove the finished drives: [{"build": …, "machine": …, "drives": n}, …].
[[nodiscard]] nlohmann::json origins_of(const StudyFolder& folder);

}  // namespace tandem
