// SPDX-License-Identifier: Apache-2.0
// `tandem run` runs a system; `tandem list` prints the components that a system can use.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommands; `status` receives the exit status after parsing.
void add_run_command(CLI::App& app, int& status);

}  // namespace tandem
