// SPDX-License-Identifier: Apache-2.0
// In: measures of many drives. Out: what they say together.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tandem/metrics/metrics.hpp"

namespace tandem {

/// A value and its 95 % confidence interval.
struct Estimate {
  double value = 0.0, low = 0.0, high = 0.0;
};

/// Median (nearest rank) with the percentile interval of the bootstrap. No samples are drawn: of n
/// values in order the k-th bounds the median of a resample with the probability that at least
/// ⌈n/2⌉ of n draws fall on the first k, which is binomial (Efron 1979, §3). Empty without values.
[[nodiscard]] std::optional<Estimate> median_of(std::vector<double> values);

/// Share `part` of `whole` with the interval of Wilson 1927. Empty if `whole` is 0.
[[nodiscard]] std::optional<Estimate> share_of(long part, long whole);

/// Drives of one scenario by one method and one driver.
struct DriveGroup {
  std::string scenario, method, driver;
  std::vector<DriveResult> drives;
};

/// In the order in which they appear.
[[nodiscard]] std::vector<DriveGroup> groups_of(const std::vector<DriveResult>& drives);

/// An object per group: scenario, method, driver, n; counts of drives that reached the goal or
/// collided, with shares; sums of collisions and of what planner and filter did; and for each
/// measure the median over the drives that have it.
[[nodiscard]] nlohmann::json summary_of(const std::vector<DriveGroup>& groups);

/// A row per group for a terminal.
[[nodiscard]] std::string study_table(const std::vector<DriveGroup>& groups);

/// Real time and CPU time: how fast, and where it went.
[[nodiscard]] std::string cost_table(const std::vector<DriveResult>& drives);

/// The drives as CSV (RFC 4180), a row each; columns as the keys of the JSON, those of nested
/// objects after a dot; what is not defined is empty.
[[nodiscard]] std::string csv_of(const std::vector<DriveResult>& drives);

}  // namespace tandem
