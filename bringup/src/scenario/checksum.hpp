// SPDX-License-Identifier: Apache-2.0
// In: bytes. Out: a number that tells contents apart; no protection against somebody's intent.
#pragma once

#include <cstdint>
#include <string_view>

namespace tandem {

/// FNV-1a, 64 bits; `sum` goes on from what came before.
[[nodiscard]] constexpr std::uint64_t checksum(std::string_view bytes,
                                               std::uint64_t sum = 14695981039346656037U) {
  for (const char byte : bytes) sum = (sum ^ static_cast<unsigned char>(byte)) * 1099511628211U;
  return sum;
}

}  // namespace tandem
