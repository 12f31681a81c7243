// SPDX-License-Identifier: Apache-2.0
// `tandem security`: creates keystores and enclaves, which define who may join a domain and which
// topics and services they may use.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

void add_security_command(CLI::App& app);

/// Adds `--enclave NAME` to a command that creates nodes.
void add_enclave_option(CLI::App& command);

}  // namespace tandem
