// SPDX-License-Identifier: Apache-2.0
// Makes text from a file or another program safe to print on one line of a terminal.
#pragma once

#include <string>

namespace tandem {

/// `text` with every control character (C0, DEL and, in UTF-8, C1) replaced by '?', so that
/// external text cannot break a line, move the cursor, change colours or forge a log line.
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
