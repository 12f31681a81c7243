// SPDX-License-Identifier: Apache-2.0
// Validates the bytes of an OctoMap tree, counts its nodes, and walks its leaves.
#pragma once

#include <octomap/OcTree.h>  // OcTreeKey.h does not include what it needs

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "tandem/map/detail/octree_keys.hpp"

namespace tandem {

/// Number of nodes of a tree in the format of .bt data (two bits per child: none, free, occupied,
/// inner). nullopt if the bytes are truncated, continue after the tree, or nest deeper than
/// OctoMap's 16 levels. OctoMap's own reader checks none of this.
[[nodiscard]] std::optional<std::size_t> count_binary_nodes(std::string_view data);

/// The same for .ot data: per node a float log-odds, `payload` bytes unrelated to occupancy (a
/// ColorOcTree's colour), and a byte of children. Infinite log-odds are accepted as certain; NaN is
/// rejected.
[[nodiscard]] std::optional<std::size_t> count_full_nodes(std::string_view data,
                                                          std::size_t payload = 0);

/// Removes the payload: converts data that count_full_nodes accepts to that of a plain OcTree.
[[nodiscard]] std::string without_payload(std::string_view data, std::size_t payload);

/// Calls `visit(first, voxels, is_occupied)` for each leaf of data that count_binary_nodes accepts:
/// the key of its lowest voxel and its side in voxels. Reading the bytes takes a tenth of the time
/// that building an octree of them and walking it does.
template <class Visit>
void for_binary_leaves(std::string_view data, const Visit& visit) {
  std::size_t at = 0;
  const auto walk = [&](const auto& deeper, const octomap::OcTreeKey& corner,
                        unsigned voxels) -> void {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(data[at + i]); };
    const unsigned record = byte(0) | static_cast<unsigned>(byte(1)) << 8U;
    at += 2;
    const unsigned half = voxels / 2;
    const auto child_corner = [&](unsigned child) {
      const auto moved = [&](unsigned axis) {
        return static_cast<octomap::key_type>(corner[axis] + (child >> axis & 1U) * half);
      };
      return octomap::OcTreeKey(moved(0), moved(1), moved(2));
    };
    for (unsigned child = 0, kinds = record; kinds != 0; ++child, kinds >>= 2U)
      if (const unsigned kind = kinds & 3U; kind == 1 || kind == 2)
        visit(child_corner(child), static_cast<int>(half), kind == 2);
    for (unsigned child = 0, kinds = record; kinds != 0; ++child, kinds >>= 2U)
      if ((kinds & 3U) == 3) deeper(deeper, child_corner(child), half);  // in this order
  };
  if (!data.empty()) walk(walk, octomap::OcTreeKey(0, 0, 0), 1U << kTreeDepth);
}

}  // namespace tandem
