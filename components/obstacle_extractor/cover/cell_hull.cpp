// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/cell_hull.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace tandem {
namespace {

// The range of x on one line between two rows of cells; empty if left > right.
struct Line {
  int left = std::numeric_limits<int>::max(), right = std::numeric_limits<int>::min();

  [[nodiscard]] bool is_empty() const { return left > right; }
  void include(int low, int high) {
    left = std::min(left, low);
    right = std::max(right, high);
  }
};

// Above 0 if c lies to the left of the line from a to b.
std::int64_t left_turn(const CellIndex& a, const CellIndex& b, const CellIndex& c) {
  return std::int64_t{b.ix - a.ix} * (c.iy - b.iy) - std::int64_t{b.iy - a.iy} * (c.ix - b.ix);
}

// Andrew's monotone chain over lines from the bottom up: the right side going up, then the left
// coming down.
CellCorners hull_of_lines(int bottom, const std::vector<Line>& lines) {
  CellCorners hull;
  hull.reserve(24);
  std::size_t fixed = 0;  // the corner at which the side begins
  const auto add = [&](const CellIndex& c) {
    while (hull.size() >= fixed + 2 && left_turn(hull[hull.size() - 2], hull.back(), c) <= 0)
      hull.pop_back();
    if (hull.empty() || hull.back().ix != c.ix || hull.back().iy != c.iy) hull.push_back(c);
  };
  const int count = static_cast<int>(lines.size());
  add({lines.front().left, bottom});
  for (int i = 0; i < count; ++i)
    if (const Line& line = lines[static_cast<std::size_t>(i)]; !line.is_empty())
      add({line.right, bottom + i});
  fixed = hull.size() - 1;
  for (int i = count - 1; i >= 0; --i)
    if (const Line& line = lines[static_cast<std::size_t>(i)]; !line.is_empty())
      add({line.left, bottom + i});
  hull.pop_back();  // the first corner again
  return hull;
}

bool is_lower(const CellIndex& a, const CellIndex& b) { return a.iy < b.iy; }

// All lines from the lowest to the highest of these, empty.
std::vector<Line>& lines_for(int low, int high) {
  thread_local std::vector<Line> lines;  // kept, because millions of hulls are computed
  lines.assign(static_cast<std::size_t>(high - low + 1), {});
  return lines;
}

}  // namespace

std::size_t HashOfCorners::operator()(const CellCorners& corners) const {
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a, a number at a time
  for (const CellIndex& corner : corners)
    for (const int number : {corner.ix, corner.iy})
      hash = (hash ^ static_cast<std::uint32_t>(number)) * 1099511628211ULL;
  return hash;
}

CellCorners hull_of(const Cells& cells) {
  const auto [low, high] = std::minmax_element(cells.begin(), cells.end(), is_lower);
  const int bottom = low->iy;
  std::vector<Line>& lines = lines_for(bottom, high->iy + 1);
  for (const CellIndex& cell : cells)
    lines[static_cast<std::size_t>(cell.iy - bottom)].include(cell.ix, cell.ix + 1);
  // So far each line has the row above it; it also bounds the row below.
  for (std::size_t i = lines.size() - 1; i > 0; --i)
    if (!lines[i - 1].is_empty()) lines[i].include(lines[i - 1].left, lines[i - 1].right);
  return hull_of_lines(bottom, lines);
}

CellCorners hull_of_both(const CellCorners& a, const CellCorners& b) {
  const int bottom = std::min(a[0].iy, b[0].iy);
  const int top = std::max(std::max_element(a.begin(), a.end(), is_lower)->iy,
                           std::max_element(b.begin(), b.end(), is_lower)->iy);
  std::vector<Line>& lines = lines_for(bottom, top);
  for (const CellCorners* corners : {&a, &b})
    for (const CellIndex& c : *corners)
      lines[static_cast<std::size_t>(c.iy - bottom)].include(c.ix, c.ix);
  return hull_of_lines(bottom, lines);
}

}  // namespace tandem
