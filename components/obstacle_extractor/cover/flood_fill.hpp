// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. Breadth-first flood fill on a row-major plane.
#pragma once

#include <cstddef>
#include <vector>

namespace tandem {

/// Appends to `cells` (indices into a row-major plane of `size` cells) all cells that are reachable
/// from them over edges, nearest first. `enters(cell, from)` decides whether a cell is entered; it
/// must return true at most once per cell.
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
