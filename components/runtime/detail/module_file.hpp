// SPDX-License-Identifier: Apache-2.0
// Reads a module's mark from its file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tandem::runtime {

/// The texts of a module's mark; see module_mark.hpp.
struct ModuleInfo {
  std::string abi, component, package;
};

/// Nothing if the file has no mark or is not a library for this kind of machine. Runs none of its
/// code.
[[nodiscard]] std::optional<ModuleInfo> read_module(const std::filesystem::path& file);

}  // namespace tandem::runtime
