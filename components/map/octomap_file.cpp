// SPDX-License-Identifier: Apache-2.0
#include "map/octomap_file.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "map/octomap_bytes.hpp"

namespace tandem {
namespace {

constexpr std::string_view kBinaryFirstLine = "# Octomap OcTree binary file";
constexpr std::string_view kFullFirstLine = "# Octomap OcTree file";
constexpr std::uintmax_t kLargestFile = 1U << 30U;  // [bytes]
constexpr double kFinest = 1e-3, kCoarsest = 10.0;  // resolution [m]
const std::string kWrongContent = "the bytes are cut off or damaged";

struct Header {
  OctomapFormat format;
  std::size_t nodes = 0;
  std::string_view data;  // what follows the header
};

// The text up to the next line feed, taken off `rest`.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// The word after a key, if the line starts with that key.
std::optional<std::string_view> value_of(std::string_view line, std::string_view key) {
  if (!line.starts_with(key) || line.size() == key.size() || line[key.size()] != ' ')
    return std::nullopt;
  line.remove_prefix(std::min(line.find_first_not_of(' ', key.size()), line.size()));
  return line.substr(0, line.find(' '));
}

template <class Number>
bool parse(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

// Header of a .bt or .ot file; nullopt if it is none.
std::optional<Header> parse_header(std::string_view rest) {
  Header header;
  const std::string_view first = take_line(rest);
  header.format.binary = first.starts_with(kBinaryFirstLine);
  if (!header.format.binary && !first.starts_with(kFullFirstLine)) return std::nullopt;
  bool sized = false, resolved = false;
  while (!rest.empty()) {
    const std::string_view line = take_line(rest);
    if (line.starts_with("data")) {
      header.data = rest;
      return sized && resolved ? std::optional(header) : std::nullopt;
    }
    if (const auto id = value_of(line, "id")) header.format.id = *id;
    if (const auto size = value_of(line, "size")) sized = parse(*size, header.nodes);
    if (const auto res = value_of(line, "res")) resolved = parse(*res, header.format.resolution);
  }
  return std::nullopt;
}

std::string read_whole(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status))
    throw std::runtime_error(name + ": no such file; give the path of an OctoMap .bt or .ot file");
  if (!std::filesystem::is_regular_file(status))
    throw std::runtime_error(name + ": not a file; give the path of an OctoMap .bt or .ot file");
  const auto size = std::filesystem::file_size(file, error);
  if (error || size > kLargestFile)
    throw std::runtime_error(name + ": larger than 1 GiB or of unknown size; use a coarser map");
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw std::runtime_error(name + ": cannot be read; check its permissions");
  return bytes;
}

bool has_occupied(const octomap::OcTree& tree) {
  return std::any_of(tree.begin_leafs(), tree.end_leafs(),
                     [&](const octomap::OcTreeNode& leaf) { return tree.isNodeOccupied(leaf); });
}

std::string format_error(const OctomapFormat& format) {
  if (format.id != "OcTree")
    return "holds a tree of type '" + format.id.substr(0, 40) +
           "', not OcTree; convert it with octomap's tools";
  if (!(format.resolution >= kFinest && format.resolution <= kCoarsest)) {
    std::ostringstream text;
    text << "resolution " << format.resolution << " m outside [" << kFinest << ", " << kCoarsest
         << "] m";
    return text.str();
  }
  return {};
}

DecodedOctomap decode(const OctomapFormat& format, std::string_view data,
                      bool may_be_empty = false) {
  if (const std::string error = format_error(format); !error.empty()) return {nullptr, error};
  if (data.empty()) {
    if (may_be_empty) return {std::make_unique<octomap::OcTree>(format.resolution), {}};
    return {nullptr, "the map is empty"};
  }
  if (!(format.binary ? count_binary_nodes(data) : count_full_nodes(data)))
    return {nullptr, kWrongContent};
  std::istringstream stream{std::string(data)};
  auto tree = std::make_unique<octomap::OcTree>(format.resolution);
  if (format.binary)
    tree->readBinaryData(stream);
  else
    tree->readData(stream);
  if (!may_be_empty && !has_occupied(*tree)) return {nullptr, "the map has no occupied voxel"};
  return {std::move(tree), {}};
}

}  // namespace

DecodedOctomap decode_octomap(const OctomapFormat& format, std::span<const std::int8_t> data,
                              bool may_be_empty) {
  return decode(format, {reinterpret_cast<const char*>(data.data()), data.size()}, may_be_empty);
}

std::vector<std::int8_t> encode_octomap(const octomap::OcTree& tree) {
  std::ostringstream stream;
  tree.writeBinaryData(stream);
  const std::string bytes = stream.str();
  return {bytes.begin(), bytes.end()};
}

std::unique_ptr<octomap::OcTree> load_octomap(const std::filesystem::path& file) {
  const std::string bytes = read_whole(file);
  const auto fail = [&](const std::string& what) -> std::runtime_error {
    return std::runtime_error(file.string() + ": " + what);
  };
  if (bytes.empty()) throw fail("the file is empty; copy it again or rebuild it");
  const auto header = parse_header(bytes);
  if (!header)
    throw fail(
        "not an OctoMap file (.bt or .ot), or its header is cut off or damaged; "
        "`tandem map build` makes one");
  const auto nodes =
      header->format.binary ? count_binary_nodes(header->data) : count_full_nodes(header->data);
  DecodedOctomap decoded = decode(header->format, header->data);
  if (decoded.tree && nodes == header->nodes) return std::move(decoded.tree);
  if (decoded.tree || decoded.error == kWrongContent)
    throw fail(
        "truncated or damaged (its tree does not end where the header says); "
        "copy it again or rebuild it");
  throw fail(decoded.error + "; give another map or rebuild it");
}

std::string bt_file_bytes(const octomap::OcTree& tree) {
  // What OcTree::writeBinaryConst writes, without its chatter on stderr.
  std::ostringstream stream;
  stream << kBinaryFirstLine << "\n"
         << "# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
         << "id " << tree.getTreeType() << "\nsize " << tree.size() << "\nres "
         << tree.getResolution() << "\ndata\n";
  tree.writeBinaryData(stream);
  return stream.str();
}

void save_octomap(const octomap::OcTree& tree, const std::filesystem::path& file) {
  const std::filesystem::path part = file.string() + ".part";  // never half a map
  std::ofstream stream(part, std::ios::binary);
  stream << bt_file_bytes(tree);
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(part, file, error);
  if (stream && !error) return;
  std::filesystem::remove(part, error);
  throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace tandem
