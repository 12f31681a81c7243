// SPDX-License-Identifier: Apache-2.0
// Private to obstacle_extractor. Convex hulls of cells, computed exactly in whole numbers.
#pragma once

#include <cstddef>
#include <vector>

#include "tandem/obstacle_extractor/cover/free_regions.hpp"

namespace tandem {

using Cells = std::vector<CellIndex>;

/// Corners of cells; (ix, iy) is the lower left corner of that cell.
using CellCorners = std::vector<CellIndex>;

struct HashOfCorners {
  [[nodiscard]] std::size_t operator()(const CellCorners& corners) const;
};

/// Corners of the convex hull of at least one cell: counter-clockwise from the lowest, of two the
/// left one. No corner lies on the line between its neighbours.
[[nodiscard]] CellCorners hull_of(const Cells& cells);

/// The convex hull of two hulls.
[[nodiscard]] CellCorners hull_of_both(const CellCorners& a, const CellCorners& b);

}  // namespace tandem
