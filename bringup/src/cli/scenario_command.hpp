// SPDX-License-Identifier: Apache-2.0
// `tandem scenario`: runs scenario files, prints the results and checks the scenarios'
// expectations.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand; `status` receives the exit status after parsing.
void add_scenario_command(CLI::App& app, int& status);

}  // namespace tandem
