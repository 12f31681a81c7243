// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/octomap_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "tandem/map/octomap_bytes.hpp"

namespace tandem {
namespace {

constexpr std::string_view kBinaryFirstLine = "# Octomap OcTree binary file";
constexpr std::string_view kFullFirstLine = "# Octomap OcTree file";
constexpr std::int32_t kLegacyOcTree = 3;
constexpr std::size_t kColor = 3;                   // [bytes]
constexpr std::uintmax_t kLargestFile = 1U << 30U;  // [bytes]
constexpr double kFinest = 1e-3, kCoarsest = 10.0;  // resolution [m]
const std::string kWrongContent = "the data are truncated or damaged";
const std::string kNothingOccupied = "the map has no occupied voxel";

struct Header {
  OctomapFormat format;
  std::size_t nodes = 0;
  std::string_view data;  // bytes after the header
};

// Reads a header word by word, as OctoMap does: keys may share a line.
class Words {
 public:
  explicit Words(std::string_view text) : rest_{text} {}

  // The next word; empty at the end.
  std::string_view next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
    const std::size_t end = std::min(rest_.find_first_of(kSpace), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
  }

  void skip_line() {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
  }

  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  static constexpr std::string_view kSpace = " \t\r\n\v\f";
  std::string_view rest_;
};

template <class Number>
bool parse(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

// Binary files from before OctoMap 1.0 start with these fields; nullopt if this one does not.
std::optional<Header> parse_legacy_header(std::string_view bytes) {
  std::int32_t tree_type = 0;
  Header header;
  std::uint32_t nodes = 0;
  constexpr std::size_t kSize = sizeof tree_type + sizeof header.format.resolution + sizeof nodes;
  if (bytes.size() < kSize) return std::nullopt;
  std::memcpy(&tree_type, bytes.data(), sizeof tree_type);
  if (tree_type != kLegacyOcTree) return std::nullopt;
  std::memcpy(&header.format.resolution, bytes.data() + sizeof tree_type,
              sizeof header.format.resolution);
  std::memcpy(&nodes, bytes.data() + kSize - sizeof nodes, sizeof nodes);
  header.nodes = nodes;
  header.data = bytes.substr(kSize);
  return header;
}

// Header of a .bt or .ot file; nullopt if there is none.
std::optional<Header> parse_header(std::string_view bytes) {
  Header header;
  header.format.id.clear();
  header.format.binary = bytes.starts_with(kBinaryFirstLine);
  if (!header.format.binary && !bytes.starts_with(kFullFirstLine))
    return parse_legacy_header(bytes);
  bool sized = false, resolved = false;
  Words words{bytes};
  words.skip_line();
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "data") {
      words.skip_line();
      header.data = words.rest();
      const bool complete = resolved && !header.format.id.empty() &&
                            (sized || !header.format.binary);  // OctoMap counts only binary nodes
      return complete ? std::optional(header) : std::nullopt;
    }
    if (word == "id")
      header.format.id = words.next();
    else if (word == "size")
      sized = parse(words.next(), header.nodes);
    else if (word == "res")
      resolved = parse(words.next(), header.format.resolution);
    else
      words.skip_line();  // a comment, or another program's key
  }
  return std::nullopt;
}

std::string read_whole(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status))
    throw std::runtime_error(
        name + ": no such file; give the path of an OctoMap (.bt, .ot) or of a map's YAML");
  if (!std::filesystem::is_regular_file(status))
    throw std::runtime_error(
        name + ": not a file; give the path of an OctoMap (.bt, .ot) or of a map's YAML");
  const auto size = std::filesystem::file_size(file, error);
  if (error || size > kLargestFile)
    throw std::runtime_error(name +
                             ": larger than 1 GiB, or its size is unknown; use a coarser map");
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw std::runtime_error(name + ": not readable; check its permissions");
  return bytes;
}

bool has_occupied(const octomap::OcTree& tree) {
  return std::any_of(tree.begin_leafs(), tree.end_leafs(),
                     [&](const octomap::OcTreeNode& leaf) { return tree.isNodeOccupied(leaf); });
}

// Bytes per node besides log-odds and children, by the tree's type; nullopt for a tree without
// log-odds.
std::optional<std::size_t> payload_of(const std::string& id) {
  if (id == "ColorOcTree") return kColor;
  // OcTreeStamped does not write its timestamps; "1" is an old name of OcTree.
  if (id == "OcTree" || id == "OcTreeStamped" || id == "1") return 0;
  return std::nullopt;
}

std::string format_error(const OctomapFormat& format) {
  // Binary data have the same meaning for every tree type; OctoMap's reader ignores the type too.
  if (!format.binary && !payload_of(format.id))
    return "contains a tree of type '" + format.id.substr(0, 40) +
           "', not OcTree, ColorOcTree or OcTreeStamped; save it as binary (.bt)";
  if (!(format.resolution >= kFinest && format.resolution <= kCoarsest)) {
    std::ostringstream text;
    text << "resolution " << format.resolution << " m outside [" << kFinest << ", " << kCoarsest
         << "] m";
    return text.str();
  }
  return {};
}

// Reads a tree of a valid format; null if the bytes are damaged.
std::unique_ptr<octomap::OcTree> read_tree(const OctomapFormat& format, std::string_view data) {
  auto tree = std::make_unique<octomap::OcTree>(format.resolution);
  if (format.binary) {
    if (!count_binary_nodes(data)) return nullptr;
    std::istringstream stream{std::string(data)};
    tree->readBinaryData(stream);
    return tree;
  }
  const std::size_t payload = payload_of(format.id).value();
  if (!count_full_nodes(data, payload)) return nullptr;
  std::istringstream stream{without_payload(data, payload)};
  tree->readData(stream);
  return tree;
}

DecodedOctomap decode(const OctomapFormat& format, std::string_view data,
                      bool may_be_empty = false) {
  if (const std::string error = format_error(format); !error.empty()) return {nullptr, error};
  if (data.empty()) {
    if (may_be_empty) return {std::make_unique<octomap::OcTree>(format.resolution), {}};
    return {nullptr, "the map is empty"};
  }
  auto tree = read_tree(format, data);
  if (!tree) return {nullptr, kWrongContent};
  if (!may_be_empty && !has_occupied(*tree)) return {nullptr, kNothingOccupied};
  return {std::move(tree), {}};
}

bool has_occupied(std::string_view data) {
  bool found = false;
  for_binary_leaves(data,
                    [&](const auto&, int, bool is_occupied) { found = found || is_occupied; });
  return found;
}

// Of binary data that are not empty; the error is empty where there is a slice.
std::string slice_error(const OctomapFormat& format, std::string_view data, bool may_be_empty) {
  if (std::string error = format_error(format); !error.empty()) return error;
  if (!count_binary_nodes(data)) return kWrongContent;
  return may_be_empty || has_occupied(data) ? "" : kNothingOccupied;
}

bool has_promised_size(const Header& header, const octomap::OcTree& tree) {
  return !header.format.binary || tree.size() == header.nodes;
}

}  // namespace

DecodedOctomap decode_octomap(const OctomapFormat& format, std::span<const std::int8_t> data,
                              bool may_be_empty) {
  return decode(format, {reinterpret_cast<const char*>(data.data()), data.size()}, may_be_empty);
}

Grid slice_octomap(const OctomapFormat& format, std::span<const std::int8_t> data,
                   const SliceParams& params, bool may_be_empty) {
  if (format.binary && !data.empty()) {
    const std::string_view bytes{reinterpret_cast<const char*>(data.data()), data.size()};
    if (const std::string error = slice_error(format, bytes, may_be_empty); !error.empty())
      throw std::runtime_error(error);
    return slice_binary(bytes, format.resolution, params);
  }
  const DecodedOctomap decoded = decode_octomap(format, data, may_be_empty);
  if (!decoded.tree) throw std::runtime_error(decoded.error);
  return slice(*decoded.tree, params);
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
  if (bytes.empty()) throw fail("the file is empty; copy it again or rebuild the map");
  const auto header = parse_header(bytes);
  if (!header)
    throw fail(
        "not an OctoMap file (.bt or .ot), or its header is truncated or damaged; `tandem map "
        "build` creates one");
  DecodedOctomap decoded = decode(header->format, header->data);
  if (decoded.tree && has_promised_size(*header, *decoded.tree)) return std::move(decoded.tree);
  if (decoded.tree || decoded.error == kWrongContent)
    throw fail(
        "truncated or damaged (its tree does not end where the header says); copy it again or "
        "rebuild the map");
  throw fail(decoded.error + "; use another map or rebuild this one");
}

std::string bt_file_bytes(const octomap::OcTree& tree) {
  // Writes the same as OcTree::writeBinaryConst, without its messages on stderr.
  std::ostringstream stream;
  stream << kBinaryFirstLine << "\n"
         << "# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
         << "id " << tree.getTreeType() << "\nsize " << tree.size() << "\nres "
         << tree.getResolution() << "\ndata\n";
  tree.writeBinaryData(stream);
  return stream.str();
}

void save_octomap(const octomap::OcTree& tree, const std::filesystem::path& file) {
  save_bt_file(bt_file_bytes(tree), file);
}

void save_bt_file(const std::string& bytes, const std::filesystem::path& file) {
  const std::filesystem::path part = file.string() + ".part";  // so that no truncated map is left
  std::ofstream stream(part, std::ios::binary);
  stream << bytes;
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(part, file, error);
  if (stream && !error) return;
  std::filesystem::remove(part, error);
  throw std::runtime_error(file.string() + ": not writable");
}

}  // namespace tandem
