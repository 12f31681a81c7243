// SPDX-License-Identifier: Apache-2.0
// `tandem run` and `tandem list`: systems and the components they can be made of.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommands; `status` receives the exit status after parsing.
void add_run_command(CLI::App& app, int& status);

}  // namespace tandem
