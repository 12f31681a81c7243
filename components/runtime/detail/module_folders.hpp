// SPDX-License-Identifier: Apache-2.0
// Private to runtime/.
#pragma once

#include <filesystem>
#include <vector>

namespace tandem::runtime {

/// The path of libtandem_runtime.so; empty if it is unknown.
[[nodiscard]] std::filesystem::path runtime_file();
/// The folders of this Tandem's modules: the program's, that of libtandem_runtime.so, and tandem/
/// in the latter.
[[nodiscard]] std::vector<std::filesystem::path> own_module_folders();

}  // namespace tandem::runtime
