// SPDX-License-Identifier: Apache-2.0
// Parts of Tandem that only some processes need, in modules of their own: libtandem-<name>.so, made
// by the CMake function tandem_extension(). Not installed.
#pragma once

#include <string>

#include "tandem/runtime/visibility.hpp"

namespace tandem::runtime {

/// Loads an extension from this Tandem's folders, never to be unloaded, and returns its function
/// `symbol`. Throws std::runtime_error, naming the file and the remedy, if the module is missing,
/// cannot be loaded or is of another version. Any thread may call it.
[[nodiscard]] TANDEM_EXPORT void* function_of_extension(const std::string& name,
                                                        const char* symbol);

}  // namespace tandem::runtime
