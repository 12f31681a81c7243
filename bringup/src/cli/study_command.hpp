// SPDX-License-Identifier: Apache-2.0
// `tandem study`: runs many drives in lockstep and summarizes their measures.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand.
void add_study_command(CLI::App& app);

}  // namespace tandem
