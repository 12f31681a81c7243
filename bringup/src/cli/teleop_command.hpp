// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds `tandem teleop`, which drives a robot with the keys of a terminal.
void add_teleop_command(CLI::App& app);

}  // namespace tandem
