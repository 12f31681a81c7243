// SPDX-License-Identifier: Apache-2.0
// In: bytes that claim to be an OctoMap tree. Out: whether they are, and how many nodes they hold.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace tandem {

/// Nodes of the tree that exactly these bytes hold, in the format of .bt data (two bits per child:
/// none, free, occupied, inner); nullopt if they are cut off, go on, or nest deeper than OctoMap's
/// 16 levels. OctoMap's own reader checks none of this.
[[nodiscard]] std::optional<std::size_t> count_binary_nodes(std::string_view data);

/// The same for .ot data: per node a float log-odds, which must be finite, and a byte of children.
[[nodiscard]] std::optional<std::size_t> count_full_nodes(std::string_view data);

}  // namespace tandem
