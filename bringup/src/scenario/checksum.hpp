// SPDX-License-Identifier: Apache-2.0
// Computes a checksum that distinguishes contents; it does not protect against deliberate changes.
#pragma once

#include <cstdint>
#include <string_view>

namespace tandem {

/// FNV-1a, 64 bits; `sum` continues from the preceding bytes.
[[nodiscard]] constexpr std::uint64_t checksum(std::string_view bytes,
                                               std::uint64_t sum = 14695981039346656037U) {
  for (const char byte : bytes) sum = (sum ^ static_cast<unsigned char>(byte)) * 1099511628211U;
  return sum;
}

}  // namespace tandem
