// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds `tandem play`, which publishes the messages of a recording on the domain.
void add_play_command(CLI::App& app);

}  // namespace tandem
