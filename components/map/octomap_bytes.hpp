// SPDX-License-Identifier: Apache-2.0
// Validates the bytes of an OctoMap tree and counts its nodes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

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

}  // namespace tandem
