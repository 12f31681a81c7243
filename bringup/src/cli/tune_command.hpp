// SPDX-License-Identifier: Apache-2.0
// `tandem tune`: searches better parameter values with simulated drives and shows what they gain.
#pragma once

#include <CLI/App.hpp>

namespace tandem {

/// Adds `tune` to the program. Its callback throws std::runtime_error or std::invalid_argument with
/// one line to print.
void add_tune_command(CLI::App& app);

}  // namespace tandem
