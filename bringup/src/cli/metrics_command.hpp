// SPDX-License-Identifier: Apache-2.0
// `tandem metrics`: computes the measures of a recorded drive.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand.
void add_metrics_command(CLI::App& app);

}  // namespace tandem
