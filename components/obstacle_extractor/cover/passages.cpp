// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/passages.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tandem/map/distance_transform.hpp"
#include "tandem/obstacle_extractor/cover/flood_fill.hpp"

namespace tandem {
namespace {

// Room to spare on either side of the disc [m]. It is less for the coarse shapes, so that a passage
// that only became narrower does not count as closed.
constexpr double kBefore = 0.075, kAfter = 0.045;
constexpr double kLeastRoom = 0.1;  // [m²]

using Mask = std::vector<std::uint8_t>;
using Labels = std::vector<int>;

// A connected part of the fine labels and the rooms that remain of it in the coarse ones, largest
// first.
struct Division {
  int part;
  std::vector<int> rooms;
};

// The parts that fall into more than one room.
std::vector<Division> divisions(const Labels& before, const Labels& after, double least) {
  std::map<int, std::map<int, int>> cells;  // cell counts by part, then by piece
  for (std::size_t i = 0; i < before.size(); ++i)
    if (before[i] != 0 && after[i] != 0) ++cells[before[i]][after[i]];
  std::vector<Division> all;
  for (const auto& [part, pieces] : cells) {
    Division division{part, {}};
    for (const auto& [piece, count] : pieces)
      if (count > least) division.rooms.push_back(piece);
    std::stable_sort(division.rooms.begin(), division.rooms.end(),
                     [&counts = pieces](int a, int b) { return counts.at(a) > counts.at(b); });
    if (division.rooms.size() > 1) all.push_back(std::move(division));
  }
  return all;
}

// Marks the shortest paths from the largest room to the others.
void mark_ways(const Division& division, const Labels& before, const Labels& after,
               std::size_t width, Mask& way) {
  constexpr auto kNowhere = static_cast<std::size_t>(-1);
  std::vector<std::size_t> cells, from(before.size(), kNowhere);
  for (std::size_t i = 0; i < before.size(); ++i)
    if (before[i] == division.part && after[i] == division.rooms[0]) {
      cells.push_back(i);
      from[i] = i;
    }
  flood_fill(cells, width, before.size(), [&](std::size_t cell, std::size_t last) {
    if (before[cell] != division.part || from[cell] != kNowhere) return false;
    from[cell] = last;
    return true;
  });
  for (auto room = division.rooms.begin() + 1; room != division.rooms.end(); ++room) {
    const auto nearest = std::find_if(cells.begin(), cells.end(),
                                      [&](std::size_t cell) { return after[cell] == *room; });
    for (std::size_t cell = *nearest; from[cell] != cell; cell = from[cell]) way[cell] = 1;
  }
}

}  // namespace

Passages::Passages(const StaticMap& map, const FreeRegions& places, const CellRect& window,
                   int region, double width, const std::vector<std::vector<CellIndex>>& clusters)
    : grid_{map.grid()},
      radius_{0.5 * width / grid_.resolution},
      window_{window},
      is_place_(window.size()),
      others_(window.size()) {
  for (int iy = window.y0; iy < window.y1; ++iy)
    for (int ix = window.x0; ix < window.x1; ++ix) {
      others_[window.index(ix, iy)] = places.gap(ix, iy) <= 0.0F ? 1 : 0;
      const int at = places.region(ix, iy);
      is_place_[window.index(ix, iy)] = at != 0 && (region == 0 || at == region) ? 1 : 0;
    }
  for (const auto& cluster : clusters)
    for (const CellIndex& cell : cluster)
      if (window.contains(cell.ix, cell.iy)) others_[window.index(cell.ix, cell.iy)] = 0;
}

// Cells whose centres lie in a shape.
Mask Passages::covered(const std::vector<Obstacle>& shapes) const {
  Mask mask(window_.size());
  for (const Obstacle& shape : shapes) {
    const Eigen::Vector2d c = (shape.p_MO - grid_.origin) / grid_.resolution;
    const int reach = static_cast<int>(circumradius(shape) / grid_.resolution) + 1;
    const int mx = static_cast<int>(std::floor(c.x())), my = static_cast<int>(std::floor(c.y()));
    for (int iy = std::max(window_.y0, my - reach); iy < std::min(window_.y1, my + reach + 1); ++iy)
      for (int ix = std::max(window_.x0, mx - reach); ix < std::min(window_.x1, mx + reach + 1);
           ++ix)
        if (contains(shape, grid_.center(ix, iy))) mask[window_.index(ix, iy)] = 1;
  }
  return mask;
}

// In cells, exact as far as the disc with its spare room reaches.
std::vector<float> Passages::distances_to(const Mask& mask) const {
  const double most = radius_ + std::max(kBefore, kAfter) / grid_.resolution;
  return distance_transform(mask, window_.width(), window_.height(),
                            static_cast<int>(std::ceil(most)) + 1);
}

// Labels the connected parts where a disc with `spare` [m] on either side fits. `to_others`:
// distance to the other occupied cells, in cells.
Labels Passages::parts(const std::vector<Obstacle>& shapes, const std::vector<float>& to_others,
                       double spare) const {
  const auto to_shapes = distances_to(covered(shapes));
  const double least = radius_ + spare / grid_.resolution;
  constexpr int kOpen = -1;  // not labelled yet
  Labels labels(window_.size());
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (is_place_[i] != 0 && static_cast<double>(std::min(to_shapes[i], to_others[i])) >= least)
      labels[i] = kOpen;
  int last = 0;
  std::vector<std::size_t> cells;
  for (std::size_t start = 0; start < labels.size(); ++start) {
    if (labels[start] != kOpen) continue;
    labels[start] = ++last;
    cells.assign(1, start);
    flood_fill(cells, static_cast<std::size_t>(window_.width()), labels.size(),
               [&](std::size_t cell, std::size_t) {
                 if (labels[cell] != kOpen) return false;
                 labels[cell] = last;
                 return true;
               });
  }
  return labels;
}

// Cells that the disc covers along the path, including its spare room.
Mask Passages::swept(const Mask& way) const {
  const auto to_way = distances_to(way);
  Mask mask(way.size());
  for (std::size_t i = 0; i < mask.size(); ++i)
    mask[i] = static_cast<double>(to_way[i]) <= radius_ + kAfter / grid_.resolution ? 1 : 0;
  return mask;
}

Mask Passages::closed(const std::vector<Obstacle>& fine,
                      const std::vector<Obstacle>& coarse) const {
  const auto to_others = distances_to(others_);
  const Labels before = parts(fine, to_others, kBefore), after = parts(coarse, to_others, kAfter);
  const auto divided = divisions(before, after, kLeastRoom / (grid_.resolution * grid_.resolution));
  if (divided.empty()) return {};
  Mask way(window_.size());
  for (const Division& division : divided)
    mark_ways(division, before, after, static_cast<std::size_t>(window_.width()), way);
  return swept(way);
}

}  // namespace tandem
