// SPDX-License-Identifier: Apache-2.0
// Finds remapping rules that rename nothing.
#pragma once

#include <string>
#include <vector>

#include "bringup/system/system.hpp"
#include "tandem/runtime/arguments.hpp"

namespace tandem {

/// One line for each remapping rule, of the system file or of the command line, whose name no node
/// that it applies to has. Nodes of components that open any topic, or that cannot be loaded, are
/// taken to have every name.
[[nodiscard]] std::vector<std::string> unused_remappings(const System& system,
                                                         const rt::RosArguments& arguments);

}  // namespace tandem
