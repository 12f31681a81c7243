// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// `tandem record`: the topics of the domain into a recording, until SIGINT or SIGTERM.
void add_record_command(CLI::App& app);

}  // namespace tandem
