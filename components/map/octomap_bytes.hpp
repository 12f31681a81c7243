// SPDX-License-Identifier: Apache-2.0
// In: bytes that claim to be an OctoMap tree. Out: whether they are, and how many nodes they hold.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace tandem {

/// Nodes of the tree that exactly these bytes hold, in the format of .bt data (two bits per child:
/// none, free, occupied, inner); nullopt if they are cut off, go on, or nest deeper than OctoMap's
/// 16 levels. OctoMap's own reader checks none of this.
[[nodiscard]] std::optional<std::size_t> count_binary_nodes(std::string_view data);

/// The same for .ot data: per node a float log-odds, `payload` bytes that say nothing of occupancy
/// (a ColorOcTree's colour), and a byte of children. Infinite log-odds are certain; NaN is refused.
[[nodiscard]] std::optional<std::size_t> count_full_nodes(std::string_view data,
                                                          std::size_t payload = 0);

/// Data that count_full_nodes accepts with this payload, as an OcTree would hold it.
[[nodiscard]] std::string without_payload(std::string_view data, std::size_t payload);

}  // namespace tandem
