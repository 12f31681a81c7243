// SPDX-License-Identifier: Apache-2.0
// Zstandard, in which rosbag2 and MCAP compress messages, chunks and whole files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tandem {

/// Whether the bytes start with a Zstandard frame header. Uncompressed CDR never does.
[[nodiscard]] bool is_zstd(std::span<const std::uint8_t> bytes);

/// What a decompressed message or chunk may have at most [bytes].
inline constexpr std::size_t kLargestMessage = std::size_t{1} << 30U;

/// Throws std::runtime_error if the bytes are damaged or hold more than `limit` bytes; allocates as
/// they come, not what they claim.
[[nodiscard]] std::vector<std::uint8_t> decompress(std::span<const std::uint8_t> bytes,
                                                   std::size_t limit = kLargestMessage);

/// One frame, at the fastest level.
[[nodiscard]] std::vector<std::uint8_t> compress(std::span<const std::uint8_t> bytes);

/// Decompresses `from` into `to` with bounded memory. Throws std::runtime_error if `from` is
/// damaged or the disk is full; `to` may then be incomplete.
void decompress_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace tandem
