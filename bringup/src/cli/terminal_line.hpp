// SPDX-License-Identifier: Apache-2.0
// Text for the status line of `tandem teleop`.
#pragma once

#include <cmath>
#include <string>

#include <spdlog/fmt/fmt.h>

namespace tandem {

/// Text from topics made safe for one line of a terminal of `width` columns: everything but
/// printable ASCII becomes '?', and what is too long is cut.
[[nodiscard]] inline std::string one_line(std::string text, std::size_t width) {
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text.substr(0, width - 1);
}

/// "clearance 0.12 m", or "clearance -" if it is unknown (NaN). In ASCII, for one_line.
[[nodiscard]] inline std::string clearance_text(double clearance) {
  return "clearance " + (std::isnan(clearance) ? "-" : fmt::format("{:.2f} m", clearance));
}

}  // namespace tandem
