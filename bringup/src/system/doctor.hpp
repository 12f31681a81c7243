// SPDX-License-Identifier: Apache-2.0
// In: what is on the domain. Out: what is wrong with it, and what to do.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tandem/runtime/domain_view.hpp"

namespace tandem {

struct Finding {
  std::string what, remedy;
};

/// What will not work between these participants, worst first.
[[nodiscard]] std::vector<Finding> examine(const rt::Domain& domain);

/// Segments of Fast DDS in `folder` that no process of `processes` ("/proc") has mapped: what a
/// killed program left. Processes that may not be read count as users of all.
[[nodiscard]] std::vector<std::string> stale_segments(const std::string& folder,
                                                      const std::string& processes);

/// `tandem doctor`.
void add_doctor_command(CLI::App& app, int& status);

}  // namespace tandem
