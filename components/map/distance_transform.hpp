// SPDX-License-Identifier: Apache-2.0
// Computes the exact distance from every cell's centre to the nearest obstacle square.
#pragma once

#include <cstdint>
#include <vector>

namespace tandem {

/// Distance from each cell's centre to the nearest obstacle square, in cells; 0 on an obstacle,
/// infinite if there is none. Exact, in time linear in the cells (Felzenszwalb and Huttenlocher,
/// "Distance Transforms of Sampled Functions", 2012).
///
/// The point of a square nearest to another cell's centre is a corner or the middle of a side. So
/// each column contributes parabolas to the envelope at its two edges only; its own cells use the
/// gap along the column, unless an edge of another column is nearer:
///
///   D²(x, y) = min over columns i of g(x − i) + h_i(y)²,   g(k) = max(0, |k| − ½)²         (1)
///
/// with h_i(y) the same gap along column i.
[[nodiscard]] std::vector<double> distance_transform(const std::vector<std::uint8_t>& is_obstacle,
                                                     int width, int height);

/// The same distances below `most` cells; `most` where they are not. For a small `most` several
/// times as fast: all columns within it are tried, which needs no envelope.
[[nodiscard]] std::vector<float> distance_transform(const std::vector<std::uint8_t>& is_obstacle,
                                                    int width, int height, int most);

}  // namespace tandem
