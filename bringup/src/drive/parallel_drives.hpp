// SPDX-License-Identifier: Apache-2.0
// In: drives to make. Out: their results, by several processes side by side.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bringup/scenario/scenario.hpp"

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

/// Does `work(0)` … `work(count − 1)` in `workers` processes, because one process has one Ipopt:
/// each takes the next piece when it is done with one. `done` is called here with each result as it
/// comes. A piece that throws, or whose process dies, leaves the others be; after the last one
/// std::runtime_error says how many failed, and of the first which and why. The processes die with
/// this one.
void work_side_by_side(std::size_t count, unsigned workers,
                       const std::function<nlohmann::json(std::size_t)>& work,
                       const std::function<void(std::size_t, const nlohmann::json&)>& done);

/// Makes each drive so, and says when one is finished; the results are in the order of the jobs.
[[nodiscard]] std::vector<DriveResult> run_side_by_side(
    const std::vector<DriveJob>& jobs, unsigned workers,
    const std::function<DriveResult(const DriveJob&)>& drive,
    const std::function<void()>& finished = [] {});

}  // namespace tandem
