// SPDX-License-Identifier: Apache-2.0
// `tandem describe`: what a component listens to, says, and can be told.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

void add_describe_command(CLI::App& app);

}  // namespace tandem
