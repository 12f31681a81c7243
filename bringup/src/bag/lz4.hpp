// SPDX-License-Identifier: Apache-2.0
// LZ4, in which some writers of MCAP compress chunks. Compiled in if liblz4 was found.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

#ifdef TANDEM_LZ4
inline constexpr bool kHasLz4 = true;
#else
inline constexpr bool kHasLz4 = false;
#endif

/// Decompresses LZ4 frames. Throws std::runtime_error if they are damaged or hold more than `limit`
/// bytes, or if this program was built without liblz4.
[[nodiscard]] std::vector<std::uint8_t> decompress_lz4(std::span<const std::uint8_t> bytes,
                                                       std::size_t limit);

}  // namespace tandem
