// SPDX-License-Identifier: Apache-2.0
// `tandem study`: many drives in lockstep, and what they say together.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand.
void add_study_command(CLI::App& app);

}  // namespace tandem
