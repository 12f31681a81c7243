// SPDX-License-Identifier: Apache-2.0
// `tandem security`: who may join a domain, and what each may do there.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

void add_security_command(CLI::App& app);

/// `--enclave NAME` for a command that makes nodes.
void add_enclave_option(CLI::App& command);

}  // namespace tandem
