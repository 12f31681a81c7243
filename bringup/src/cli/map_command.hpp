// SPDX-License-Identifier: Apache-2.0
// In: the command line after `tandem map`. Out: maps built, described and drawn.
#pragma once

#include <CLI/App.hpp>

namespace tandem {

/// Adds `map build`, `map info` and `map render` to the program. Their callbacks throw
/// std::runtime_error or std::invalid_argument with one line to print.
void add_map_command(CLI::App& program);

}  // namespace tandem
