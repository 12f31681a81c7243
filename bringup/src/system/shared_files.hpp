// SPDX-License-Identifier: Apache-2.0
// Finds the systems, scenarios, studies, robots, maps and scripts that come with Tandem.
#pragma once

#include <filesystem>
#include <string>

#include "tandem/config/yaml_reader.hpp"

namespace tandem {

/// Folder `share/tandem` of the installation that this program belongs to, or of its build folder.
/// Throws std::runtime_error if there is none.
[[nodiscard]] std::filesystem::path share_folder();

/// The file that a command's argument means: the file of that path if there is one, otherwise the
/// file of that name, with or without ".yaml", in share_folder()/bringup/`kind`. Kinds are
/// "systems", "scenarios" and "studies". Throws std::invalid_argument listing the names in that
/// folder if there is neither.
[[nodiscard]] std::string find_file(const std::string& argument, const std::string& kind);

/// The same for a value of a YAML file, whose path is relative to that file; the errors name file
/// and line. Kinds are "robots", and "maps", which are share_folder()/maps with ".bt" or ".yaml".
[[nodiscard]] std::string find_file(const YamlReader& value, const std::string& kind);

}  // namespace tandem
