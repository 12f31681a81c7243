// SPDX-License-Identifier: Apache-2.0
#include "bringup/bag/zstd.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

namespace tandem {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic{0x28, 0xb5, 0x2f, 0xfd};

using Stream = std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)>;

// Returns 0 at the end of a frame, otherwise a hint of how many input bytes remain.
std::size_t step(const Stream& stream, ZSTD_outBuffer& out, ZSTD_inBuffer& in) {
  const std::size_t left = ZSTD_decompressStream(stream.get(), &out, &in);
  if (ZSTD_isError(left)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(left));
  return left;
}

// Decompresses everything `read` supplies and passes it to `write`. `read` fills a buffer and
// returns the number of bytes; 0 at the end.
template <class Read, class Write>
void decompress_all(const Read& read, const Write& write) {
  const Stream stream{ZSTD_createDStream(), ZSTD_freeDStream};
  std::vector<char> in(ZSTD_DStreamInSize()), out(ZSTD_DStreamOutSize());
  std::size_t left = 1;
  while (const std::size_t size = read(in)) {
    ZSTD_inBuffer input{in.data(), size, 0};
    bool is_full = false;  // zstd may hold more output although all input is consumed
    while (input.pos < input.size || (is_full && left != 0)) {
      ZSTD_outBuffer output{out.data(), out.size(), 0};
      left = step(stream, output, input);
      write(std::span{out}.first(output.pos));
      is_full = output.pos == output.size;
    }
  }
  if (left != 0) throw std::runtime_error("zstd: truncated");
}

}  // namespace

bool is_zstd(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

std::vector<std::uint8_t> decompress(std::span<const std::uint8_t> bytes, std::size_t limit) {
  std::vector<std::uint8_t> plain;
  decompress_all(
      [&](std::vector<char>& buffer) {
        const auto part = bytes.first(std::min(bytes.size(), buffer.size()));
        std::copy(part.begin(), part.end(), buffer.begin());
        bytes = bytes.subspan(part.size());
        return part.size();
      },
      [&](std::span<const char> part) {
        if (part.size() > limit - plain.size())
          throw std::runtime_error("zstd: more than " + std::to_string(limit) + " bytes");
        plain.insert(plain.end(), part.begin(), part.end());
      });
  return plain;
}

std::vector<std::uint8_t> compress(std::span<const std::uint8_t> bytes) {
  constexpr int kFastest = 1;
  std::vector<std::uint8_t> packed(ZSTD_compressBound(bytes.size()));
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kFastest);
  if (ZSTD_isError(size)) throw std::runtime_error(std::string{"zstd: "} + ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

void decompress_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::ifstream compressed{from, std::ios::binary};
  std::ofstream plain{to, std::ios::binary};
  if (!compressed) throw std::runtime_error("not readable; check its permissions");
  decompress_all(
      [&](std::vector<char>& buffer) {
        compressed.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
        return static_cast<std::size_t>(compressed.gcount());
      },
      [&](std::span<const char> part) {
        if (!plain.write(part.data(), static_cast<std::streamsize>(part.size())).flush())
          throw std::runtime_error("the decompressed file does not fit into " +
                                   to.parent_path().string() +
                                   "; choose another folder with TMPDIR");
      });
}

}  // namespace tandem
