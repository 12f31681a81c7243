// SPDX-License-Identifier: Apache-2.0
// `tandem scenario`: drives scenario files, reports, and says whether what must hold did hold.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand; `status` receives the exit status after parsing.
void add_scenario_command(CLI::App& app, int& status);

}  // namespace tandem
