// SPDX-License-Identifier: Apache-2.0
// Reads PGM and PNG files as brightness.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tandem {

/// Rows from the top, `width` pixels each.
struct GrayImage {
  static constexpr std::uint16_t kWhite = 65535;

  int width = 0, height = 0;
  std::vector<std::uint16_t> shade;    ///< mean of the colours; 0 black, kWhite white
  std::vector<std::uint16_t> opacity;  ///< 0 transparent, kWhite opaque; empty: all is opaque
};

/// Reads a .pgm (P2, P5) or .png, told apart by their first bytes. Gamma is not applied. Throws
/// std::runtime_error, one line that names the file, if it is damaged or has more than kMostCells
/// pixels; memory is taken only for as many pixels as the header promises and never for more.
[[nodiscard]] GrayImage read_gray_image(const std::filesystem::path& file);

}  // namespace tandem
