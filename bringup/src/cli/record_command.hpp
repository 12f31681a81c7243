// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds `tandem record`, which records the topics of the domain until SIGINT or SIGTERM.
void add_record_command(CLI::App& app);

}  // namespace tandem
