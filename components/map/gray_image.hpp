// SPDX-License-Identifier: Apache-2.0
// Reads PGM and PNG files as brightness.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tandem {

/// Pixels row by row from the top, `width` per row.
struct GrayImage {
  static constexpr std::uint16_t kWhite = 65535;

  int width = 0, height = 0;
  std::vector<std::uint16_t> shade;    ///< mean of the colours; 0 black, kWhite white
  std::vector<std::uint16_t> opacity;  ///< 0 transparent, kWhite opaque; empty: all is opaque
};

/// Reads a .pgm (P2, P5) or .png file, recognised by its first bytes. Gamma is not applied. Throws
/// std::runtime_error, one line that names the file, if it is damaged or has more than kMaxCells
/// pixels. Never allocates memory for more pixels than the header declares.
[[nodiscard]] GrayImage read_gray_image(const std::filesystem::path& file);

}  // namespace tandem
