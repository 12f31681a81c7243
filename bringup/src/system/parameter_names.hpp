// SPDX-License-Identifier: Apache-2.0
// Looks a parameter's name up in all components, for values that are given to every node.
#pragma once

#include <string>

namespace tandem {

/// Whether any component that can be loaded, or every node, has a parameter of that name. Loads
/// modules until one has it. Thread-safe.
[[nodiscard]] bool is_parameter(const std::string& name);

/// "; did you mean `name`?" with the parameter of any component whose name is nearest to `word`;
/// empty if none is close enough. Loads all modules. Thread-safe.
[[nodiscard]] std::string nearest_parameter(const std::string& word);

}  // namespace tandem
