// SPDX-License-Identifier: Apache-2.0
// Decompresses what rosbag2 compressed with Zstandard: messages and whole files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tandem {

/// Whether the bytes begin as a Zstandard frame does. Plain CDR never does.
[[nodiscard]] bool is_zstd(std::span<const std::uint8_t> bytes);

/// Throws std::runtime_error if the bytes are damaged or hold more than 1 GiB.
[[nodiscard]] std::vector<std::uint8_t> decompress(std::span<const std::uint8_t> bytes);

/// Writes what `from` holds to `to`, in little memory. Throws std::runtime_error if `from` is
/// damaged or the disk is full; a part of `to` may exist then.
void decompress_file(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace tandem
