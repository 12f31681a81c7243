// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/clutter_world.hpp"

#include <array>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tandem/map/static_map.hpp"

namespace tandem {
namespace {

constexpr double kPitch = 0.15;  // [m] of the lattice; also the diameter of a cylinder
constexpr int kColumns = 30, kRows = 93;
constexpr int kFirst = 31, kLast = 61;  // rows of clutter
constexpr int kTries = 200;

using Lattice = std::vector<std::array<bool, kColumns>>;

bool is_wall(int row, int column) {
  return row < kLast && (row == 0 || column == 0 || column == kColumns - 1);
}

// Gives the same result on every machine, unlike the standard library's distributions.
bool happens(std::mt19937& random, double chance) {
  return static_cast<double>(random()) < chance * 4294967296.0;
}

int filled_neighbours(const Lattice& cells, int row, int column) {
  int count = 0;
  for (int r = row - 1; r <= row + 1; ++r)
    for (int c = column - 1; c <= column + 1; ++c)
      if ((r != row || c != column) && c >= 0 && c < kColumns)
        count += cells[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] ? 1 : 0;
  return count;
}

Lattice smoothed(const Lattice& cells) {
  Lattice next = cells;
  for (int row = kFirst; row < kLast; ++row)
    for (int column = 1; column + 1 < kColumns; ++column) {
      const int count = filled_neighbours(cells, row, column);
      bool& cell = next[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
      cell = count >= 5 || (cell && count > 2);
    }
  return next;
}

Lattice grow(std::mt19937& random, const ClutterParams& params) {
  Lattice cells(kRows);
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column)
      cells[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          is_wall(row, column) || (row >= kFirst && row < kLast && happens(random, params.fill));
  for (int step = 0; step < params.smoothing; ++step) cells = smoothed(cells);
  return cells;
}

MapDescription describe(const Lattice& cells) {
  MapDescription map;
  map.low = {-kPitch * kColumns, 0.0, 0.0};
  map.high = {0.0, kPitch * kRows, 1.0};
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      if (!cells[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)]) continue;
      Solid solid;
      solid.shape = Solid::Shape::kDisc;
      solid.p_MC = {kPitch * (column + 0.5 - kColumns), kPitch * (row + 0.5)};
      solid.size.setConstant(kPitch);
      solid.z_high = 1.0;
      map.solids.push_back(solid);
    }
  return map;
}

// The plane of that world, with each cylinder as its bounding square.
StaticMap plane(const Lattice& cells) {
  constexpr int kFine = 3;
  Grid grid{kPitch / kFine, {-kPitch * kColumns, 0.0}, kFine * kColumns, kFine * kRows, {}};
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix)
      grid.cells.push_back(
          cells[static_cast<std::size_t>(iy / kFine)][static_cast<std::size_t>(ix / kFine)]
              ? Cell::kOccupied
              : Cell::kFree);
  return StaticMap(std::move(grid), true);
}

}  // namespace

MapDescription clutter_world(unsigned seed, const ClutterParams& params) {
  check(params);
  std::mt19937 random{seed};
  for (int i = 0; i < kTries; ++i) {
    const Lattice cells = grow(random, params);
    if (plane(cells).can_pass(kClutterStart, kClutterGoal, 0.5 * params.width))
      return describe(cells);
  }
  throw std::runtime_error("clutter: no passable world in " + std::to_string(kTries) +
                           " attempts; lower fill or width");
}

}  // namespace tandem
