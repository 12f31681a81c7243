// SPDX-License-Identifier: Apache-2.0
// Quotes words for commands that a shell runs.
#pragma once

#include <string>

namespace tandem {

/// The word as a shell reads it back unchanged.
[[nodiscard]] inline std::string shell_quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace tandem
