// SPDX-License-Identifier: Apache-2.0
// In: bytes of an OctoMap, from a file or from an octomap_msgs/Octomap. Out: the tree, or why not.
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tandem {

/// The fields of an octomap_msgs/Octomap that say what its bytes are.
struct OctomapFormat {
  std::string id = "OcTree";  ///< the tree's type: OcTree, ColorOcTree, OcTreeStamped
  bool binary = true;         ///< occupied or free only (as in .bt); false: log-odds (as in .ot)
  double resolution = 0.05;   ///< [m]
};

/// A tree, or (if there is none) one line saying what is wrong with the bytes.
struct DecodedOctomap {
  std::unique_ptr<octomap::OcTree> tree;
  std::string error;
};

/// Decodes the `data` of an octomap_msgs/Octomap: of any binary tree, of a full one of the types
/// above; what it holds beside occupancy is left out. The bytes are checked whole before OctoMap
/// sees them: any bytes are safe, memory stays proportional to them. A map without a single
/// occupied voxel is an error too, unless it may be empty. Never throws.
[[nodiscard]] DecodedOctomap decode_octomap(const OctomapFormat& format,
                                            std::span<const std::int8_t> data,
                                            bool may_be_empty = false);

/// The `data` of a binary octomap_msgs/Octomap (id "OcTree").
[[nodiscard]] std::vector<std::int8_t> encode_octomap(const octomap::OcTree& tree);

/// Reads a .bt or .ot file, told apart by their first line, or a .bt of before OctoMap 1.0. The
/// `size` in the header of an .ot file does not count, as with OctoMap. Throws std::runtime_error:
/// one line that names the file, what is wrong and how to mend it.
[[nodiscard]] std::unique_ptr<octomap::OcTree> load_octomap(const std::filesystem::path& file);

/// The bytes of a .bt file. Equal trees give equal bytes.
[[nodiscard]] std::string bt_file_bytes(const octomap::OcTree& tree);

/// Writes a .bt file. Throws std::runtime_error naming the file.
void save_octomap(const octomap::OcTree& tree, const std::filesystem::path& file);

}  // namespace tandem
