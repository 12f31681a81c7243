// SPDX-License-Identifier: Apache-2.0
// `tandem security`: creates keystores and enclaves, which define who may join a domain and which
// topics and services they may use.
#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

void add_security_command(CLI::App& app);

}  // namespace tandem
