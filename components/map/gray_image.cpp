// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/gray_image.hpp"

#include <png.h>

#include <algorithm>
#include <cctype>
#include <csetjmp>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tandem/map/grid.hpp"

namespace tandem {
namespace {

constexpr int kByte = 255, kWord = 65535;
constexpr std::size_t kMaxDeflated = 1032;  // largest expansion of one byte of a PNG [bytes]

std::string too_large(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + " × " + std::to_string(height) +
         " pixels: must be between 1 and 10⁸; crop the map or make it coarser";
}

bool is_size(std::int64_t width, std::int64_t height) {
  return width > 0 && height > 0 && width <= kMaxCells && height <= kMaxCells / width;
}

// --- PGM ---

// The bytes of a PGM file; throws on errors in them.
class PgmStream {
 public:
  explicit PgmStream(std::ifstream& stream) : in_{stream} {}

  // A number in the header or in a plain file. Comments run from # to the end of the line.
  int number(int most) {
    skip_space();
    int value = 0, digits = 0;
    for (; std::isdigit(in_.peek()) != 0; ++digits) {
      value = 10 * value + (in_.get() - '0');
      if (value > most) throw std::runtime_error("a number in its header is too large");
    }
    if (digits == 0) throw std::runtime_error("truncated or damaged; save it again");
    return value;
  }

  void read(std::vector<std::uint8_t>& bytes) {
    if (!in_.read(reinterpret_cast<char*>(bytes.data()),
                  static_cast<std::streamsize>(bytes.size())))
      throw std::runtime_error("truncated: it holds fewer pixels than its header declares");
  }

  void skip_one() { in_.get(); }

 private:
  void skip_space() {
    while (std::isspace(in_.peek()) != 0 || in_.peek() == '#')
      if (in_.get() == '#') in_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }

  std::ifstream& in_;
};

std::uint16_t scaled(int value, int white) {
  return static_cast<std::uint16_t>((std::int64_t{value} * GrayImage::kWhite + white / 2) / white);
}

std::vector<std::uint16_t> binary_row(PgmStream& stream, std::vector<std::uint8_t>& bytes,
                                      int white) {
  stream.read(bytes);
  const std::size_t step = white > kByte ? 2 : 1;
  std::vector<std::uint16_t> row;
  for (std::size_t i = 0; i < bytes.size(); i += step) {
    const int value = step == 2 ? bytes[i] << 8 | bytes[i + 1] : bytes[i];
    row.push_back(scaled(std::min(value, white), white));
  }
  return row;
}

std::vector<std::uint16_t> plain_row(PgmStream& stream, int width, int white) {
  std::vector<std::uint16_t> row;
  for (int i = 0; i < width; ++i) row.push_back(scaled(stream.number(white), white));
  return row;
}

GrayImage read_pgm(std::ifstream& file, bool is_binary) {
  PgmStream stream{file};
  GrayImage image;
  constexpr int kMaxDigits = 100'000'000;  // more than kMaxCells allows, and no overflow
  image.width = stream.number(kMaxDigits);
  image.height = stream.number(kMaxDigits);
  const int white = stream.number(kWord);
  if (!is_size(image.width, image.height) || white == 0)
    throw std::runtime_error(too_large(image.width, image.height));
  if (is_binary) stream.skip_one();
  std::vector<std::uint8_t> bytes(
      is_binary ? static_cast<std::size_t>(image.width) * (white > kByte ? 2 : 1) : 0);
  for (int y = 0; y < image.height; ++y) {  // grows with the file, whatever the header claims
    const auto row =
        is_binary ? binary_row(stream, bytes, white) : plain_row(stream, image.width, white);
    image.shade.insert(image.shade.end(), row.begin(), row.end());
  }
  return image;
}

// --- PNG ---

// State and error of libpng. It exits by longjmp, so no object with a destructor may live in the
// frames that it skips.
struct PngReader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::string error;

  PngReader();
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  // Return whether libpng succeeded.
  [[nodiscard]] bool read_header(std::FILE* file);
  [[nodiscard]] bool read_pixels(png_bytepp rows);
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  static_cast<PngReader*>(png_get_error_ptr(png))->error = text;
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

PngReader::PngReader() {
  png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
  info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr) throw std::runtime_error("libpng could not be initialized");
}

bool PngReader::read_header(std::FILE* file) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_user_limits(png, static_cast<png_uint_32>(kMaxCells),
                      static_cast<png_uint_32>(kMaxCells));
  png_init_io(png, file);
  png_read_info(png, info);
  png_set_expand(png);  // palettes and small depths become 8 bits per channel; 16 bits stay
  (void)png_set_interlace_handling(png);
  png_read_update_info(png, info);
  return true;
}

bool PngReader::read_pixels(png_bytepp rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

struct PixelLayout {
  std::size_t channels = 1, bytes = 1;  // bytes per channel

  [[nodiscard]] bool has_opacity() const { return channels % 2 == 0; }
  [[nodiscard]] std::uint16_t channel(const png_byte* pixel, std::size_t i) const {
    const png_byte* value = pixel + i * bytes;
    return static_cast<std::uint16_t>(bytes == 2 ? value[0] << 8 | value[1] : value[0] * 257);
  }
  [[nodiscard]] std::uint16_t shade(const png_byte* pixel) const {
    const std::size_t colors = channels - (has_opacity() ? 1 : 0);
    unsigned sum = 0;
    for (std::size_t i = 0; i < colors; ++i) sum += channel(pixel, i);
    return static_cast<std::uint16_t>((sum + colors / 2) / colors);
  }
};

void take_pixels(const std::vector<png_byte>& pixels, const PixelLayout& layout, GrayImage& image) {
  const std::size_t step = layout.channels * layout.bytes;
  for (std::size_t i = 0; i < pixels.size(); i += step) {
    image.shade.push_back(layout.shade(&pixels[i]));
    if (layout.has_opacity())
      image.opacity.push_back(layout.channel(&pixels[i], layout.channels - 1));
  }
}

GrayImage read_png(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{std::fopen(path.c_str(), "rb"),
                                                             std::fclose};
  PngReader reader;
  if (!file || !reader.read_header(file.get()))
    throw std::runtime_error("not a readable PNG: " + reader.error);
  const std::int64_t width = png_get_image_width(reader.png, reader.info);
  const std::int64_t height = png_get_image_height(reader.png, reader.info);
  if (!is_size(width, height)) throw std::runtime_error(too_large(width, height));
  GrayImage image{static_cast<int>(width), static_cast<int>(height), {}, {}};
  const PixelLayout layout{png_get_channels(reader.png, reader.info),
                           png_get_bit_depth(reader.png, reader.info) / 8U};
  const std::size_t row = png_get_rowbytes(reader.png, reader.info);
  const std::size_t size = row * static_cast<std::size_t>(height);
  if (size / kMaxDeflated > std::filesystem::file_size(path))
    throw std::runtime_error("truncated: the file is too small for the pixels its header declares");
  std::vector<png_byte> pixels(size);
  std::vector<png_bytep> rows;
  for (std::size_t at = 0; at < pixels.size(); at += row) rows.push_back(&pixels[at]);
  if (!reader.read_pixels(rows.data()))
    throw std::runtime_error("truncated or damaged: " + reader.error);
  take_pixels(pixels, layout, image);
  return image;
}

GrayImage read(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw std::runtime_error("no such file; `image` is relative to the folder of the map's YAML");
  std::ifstream file{path, std::ios::binary};
  char first[2]{};
  file.read(first, sizeof first);
  const std::string_view magic{first, sizeof first};
  if (magic == "P5" || magic == "P2") return read_pgm(file, magic == "P5");
  if (magic == "\x89P") return read_png(path);
  throw std::runtime_error("neither PGM (P2, P5) nor PNG; convert it with: convert " +
                           path.filename().string() + " map.png");
}

}  // namespace

GrayImage read_gray_image(const std::filesystem::path& file) {
  try {
    return read(file);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace tandem
