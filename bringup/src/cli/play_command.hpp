// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// `tandem play`: a recording back onto the domain.
void add_play_command(CLI::App& app);

}  // namespace tandem
