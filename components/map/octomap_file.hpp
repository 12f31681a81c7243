// SPDX-License-Identifier: Apache-2.0
// Reads and writes OctoMaps, from files and from octomap_msgs/Octomap.
#pragma once

#include <octomap/OcTree.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/map/slice.hpp"

namespace tandem {

/// The fields of an octomap_msgs/Octomap that describe its bytes.
struct OctomapFormat {
  std::string id = "OcTree";  ///< the tree's type: OcTree, ColorOcTree, OcTreeStamped
  bool binary = true;         ///< occupied or free only (as in .bt); false: log-odds (as in .ot)
  double resolution = 0.05;   ///< [m]
};

/// A tree, or, if it is null, one line with the error in the bytes.
struct DecodedOctomap {
  std::unique_ptr<octomap::OcTree> tree;  ///< null if the message is unusable
  std::string error;                      ///< why; empty with a tree
};

/// Decodes the `data` of an octomap_msgs/Octomap: a binary tree of any type, or a full one of the
/// types above; data other than occupancy are dropped. The bytes are checked completely before
/// OctoMap reads them: any bytes are safe, and memory stays proportional to them. A map without a
/// single occupied voxel is an error too, unless `may_be_empty`. Never throws.
[[nodiscard]] DecodedOctomap decode_octomap(const OctomapFormat& format,
                                            std::span<const std::int8_t> data,
                                            bool may_be_empty = false);

/// The slice of the map that decode_octomap reads; binary data are sliced without building a tree.
/// Throws std::runtime_error with the error in the bytes, and as slice().
[[nodiscard]] Grid slice_octomap(const OctomapFormat& format, std::span<const std::int8_t> data,
                                 const SliceParams& params, bool may_be_empty = false);

/// The `data` of a binary octomap_msgs/Octomap (id "OcTree").
[[nodiscard]] std::vector<std::int8_t> encode_octomap(const octomap::OcTree& tree);

/// Reads a .bt or .ot file, recognised by its first line, or a .bt file from before OctoMap 1.0.
/// The `size` in the header of an .ot file is ignored, as OctoMap does. Throws std::runtime_error:
/// one line that names the file, the error and its remedy.
[[nodiscard]] std::unique_ptr<octomap::OcTree> load_octomap(const std::filesystem::path& file);

/// The bytes of a .bt file. Equal trees give equal bytes.
[[nodiscard]] std::string bt_file_bytes(const octomap::OcTree& tree);

/// Writes what bt_file_bytes() gave, so that no truncated file is left. Throws std::runtime_error
/// naming the file.
void save_bt_file(const std::string& bytes, const std::filesystem::path& file);

/// save_bt_file() for a tree.
void save_octomap(const octomap::OcTree& tree, const std::filesystem::path& file);

}  // namespace tandem
