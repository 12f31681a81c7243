// SPDX-License-Identifier: Apache-2.0
// Decompresses messages and whole files that rosbag2 compressed with Zstandard.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tandem {

/// Whether the bytes start with a Zstandard frame header. Uncompressed CDR never does.
[[nodiscard]] bool is_zstd(std::span<const std::uint8_t> bytes);

/// Throws std::runtime_error if the bytes are damaged or hold more than 1 GiB.
[[nodiscard]] std::vector<std::uint8_t> decompress(std::span<const std::uint8_t> bytes);

/// Decompresses `from` into `to` with bounded memory. Throws std::runtime_error if `from` is
/// damaged or the disk is full; `to` may then be incomplete.
void decompress_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace tandem
