// SPDX-License-Identifier: Apache-2.0
// `tandem robot`: makes a robot file of a URDF.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand.
void add_robot_command(CLI::App& app);

}  // namespace tandem
