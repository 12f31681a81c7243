// SPDX-License-Identifier: Apache-2.0
// In: drives to make. Out: their results, in order, by several processes side by side.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bringup/scenario.hpp"

namespace tandem {

/// One drive to make.
struct DriveJob {
  Scenario scenario;
  DriveOptions options;
};

struct SeedRange {
  unsigned first, last;
};

/// Reads "A-B". Throws std::invalid_argument naming the option unless 1 <= A <= B.
[[nodiscard]] SeedRange seed_range(const std::string& option, const std::string& text);

/// Makes each drive in one of `workers` processes: one process has one Ipopt. Throws
/// std::runtime_error if a worker did not finish; what went wrong is on standard error then.
[[nodiscard]] std::vector<DriveResult> run_side_by_side(
    const std::vector<DriveJob>& jobs, unsigned workers,
    const std::function<DriveResult(const DriveJob&)>& drive);

}  // namespace tandem
