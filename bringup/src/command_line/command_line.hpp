// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace tandem {

/// Runs the command that the arguments name, of those that `add` adds; `add` may keep the reference
/// to the exit status. Prints errors. Returns the exit status of the program.
[[nodiscard]] int run_command_line(int argc, char** argv,
                                   const std::function<void(CLI::App&, int& status)>& add);

/// Adds `--enclave NAME` to a command that creates nodes.
void add_enclave_option(CLI::App& command);

}  // namespace tandem
