// SPDX-License-Identifier: Apache-2.0
// Finds problems among the participants of a DDS domain and suggests remedies.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tandem/runtime/domain_view.hpp"

namespace tandem {

struct Finding {
  std::string what, remedy;
  bool is_note = false;  ///< no problem, only why the robot stands, as that nobody steers
};

/// Problems between these participants, worst first.
[[nodiscard]] std::vector<Finding> examine(const rt::Domain& domain);

/// Fast DDS shared-memory segments in `folder` that no process in `processes` ("/proc") has mapped:
/// leftovers of killed programs. An unreadable process counts as a user of every segment.
[[nodiscard]] std::vector<std::string> stale_segments(const std::string& folder,
                                                      const std::string& processes);

/// `tandem doctor`.
void add_doctor_command(CLI::App& app, int& status);

}  // namespace tandem
