// SPDX-License-Identifier: Apache-2.0
// `tandem map`: builds, describes and draws maps.
#pragma once

#include <CLI/App.hpp>

namespace tandem {

/// Adds `map build`, `map info` and `map render` to the program. Their callbacks throw
/// std::runtime_error or std::invalid_argument with one line to print.
void add_map_command(CLI::App& program);

}  // namespace tandem
