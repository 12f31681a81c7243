// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/lz4.hpp"

#include <stdexcept>
#include <string>

#ifdef TANDEM_LZ4
#include <lz4frame.h>

#include <memory>
#endif

namespace tandem {

#ifdef TANDEM_LZ4
std::vector<std::uint8_t> decompress_lz4(std::span<const std::uint8_t> bytes, std::size_t limit) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)))
    throw std::runtime_error("lz4: no memory");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context{
      raw, LZ4F_freeDecompressionContext};
  std::vector<std::uint8_t> plain, part(std::size_t{1} << 16U);
  std::size_t left = 1, written = 0;
  do {
    std::size_t read = bytes.size();
    written = part.size();
    left = LZ4F_decompress(context.get(), part.data(), &written, bytes.data(), &read, nullptr);
    if (LZ4F_isError(left))
      throw std::runtime_error(std::string{"lz4: "} + LZ4F_getErrorName(left));
    if (written > limit - plain.size())
      throw std::runtime_error("lz4: more than " + std::to_string(limit) + " bytes");
    plain.insert(plain.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(written));
    bytes = bytes.subspan(read);
  } while (!bytes.empty() || written == part.size());
  if (left != 0) throw std::runtime_error("lz4: truncated");
  return plain;
}
#else
std::vector<std::uint8_t> decompress_lz4(std::span<const std::uint8_t> /*bytes*/,
                                         std::size_t /*limit*/) {
  throw std::runtime_error("lz4: this program was built without liblz4");
}
#endif

}  // namespace tandem
