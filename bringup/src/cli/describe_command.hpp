// SPDX-License-Identifier: Apache-2.0
// `tandem describe`: prints the topics, services and parameters of a component.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

void add_describe_command(CLI::App& app);

}  // namespace tandem
