// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. In: cells of a plane. Out: those that can be reached from them.
#pragma once

#include <cstddef>
#include <vector>

namespace tandem {

/// Adds to `cells` (indices of a row-major plane of `size` cells) what can be reached from them
/// over sides, the nearest first: the cells for which `enters(cell, from)` is true, which it has to
/// be only once for each.
template <class Enters>
void flood_fill(std::vector<std::size_t>& cells, std::size_t width, std::size_t size,
                const Enters& enters) {
  for (std::size_t next = 0; next < cells.size(); ++next) {
    const std::size_t cell = cells[next];
    const auto visit = [&](std::size_t other) {
      if (enters(other, cell)) cells.push_back(other);
    };
    if (cell % width > 0) visit(cell - 1);
    if (cell % width + 1 < width) visit(cell + 1);
    if (cell >= width) visit(cell - width);
    if (cell + width < size) visit(cell + width);
  }
}

}  // namespace tandem
