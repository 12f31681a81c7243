// SPDX-License-Identifier: Apache-2.0
// In: text from a file or from another program. Out: text that is safe in one line of a terminal.
#pragma once

#include <string>

namespace tandem {

/// `text` with '?' for every control character: C0, DEL and, in UTF-8, C1. A line stays a line, and
/// no text that came from outside moves the cursor, changes colours or forges a line of the log.
[[nodiscard]] inline std::string printable(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto before = static_cast<unsigned char>(i == 0 ? '\0' : text[i - 1]);
    const bool is_c1 = before == 0xc2 && byte >= 0x80 && byte < 0xa0;
    if (is_c1) text.erase(--i, 1);
    if (is_c1 || byte < 0x20 || byte == 0x7f) text[i] = '?';
  }
  return text;
}

}  // namespace tandem
