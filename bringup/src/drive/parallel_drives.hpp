// SPDX-License-Identifier: Apache-2.0
// Runs drives in parallel worker processes.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bringup/scenario/scenario.hpp"

namespace tandem {

/// One drive to run.
struct DriveJob {
  Scenario scenario;
  DriveOptions options;
};

struct SeedRange {
  unsigned first, last;
};

/// Parses "A-B", or "N" for 1-N. Throws std::invalid_argument naming the option unless 1 <= A <= B
/// and the range has at most 100000 seeds.
[[nodiscard]] SeedRange seed_range(const std::string& option, const std::string& text);

/// Runs `work(0)` … `work(count − 1)` in `workers` processes rather than threads, because Ipopt's
/// MUMPS is not thread safe. Each process takes the next job when it has finished one. `done` is
/// called in the calling process with each result as it arrives. A job that throws, or whose
/// process dies, does not affect the others; after the last job a std::runtime_error reports how
/// many failed and the first error. The workers are killed when this process ends.
void work_side_by_side(std::size_t count, unsigned workers,
                       const std::function<nlohmann::json(std::size_t)>& work,
                       const std::function<void(std::size_t, const nlohmann::json&)>& done);

/// Runs the jobs with work_side_by_side and calls `finished` after each. The results are in the
/// order of the jobs.
[[nodiscard]] std::vector<DriveResult> run_side_by_side(
    const std::vector<DriveJob>& jobs, unsigned workers,
    const std::function<DriveResult(const DriveJob&)>& drive,
    const std::function<void()>& finished = [] {});

}  // namespace tandem
