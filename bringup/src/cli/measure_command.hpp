// SPDX-License-Identifier: Apache-2.0
// `tandem measure`: takes a robot file's delays and braking from a recording of steps.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand.
void add_measure_command(CLI::App& app);

}  // namespace tandem
