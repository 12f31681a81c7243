// SPDX-License-Identifier: Apache-2.0
#include "tandem/safety_filter/share_cover.hpp"

#include <bitset>

namespace tandem {
namespace {

constexpr int kDivisions = 64;  // finest subdivision of each side of the square of shares
constexpr int kMaxChecks = 400;

// From (i0, j0) to (i1, j1) in units of 1 / kDivisions, i along v and j along w.
struct Square {
  int i0, i1, j0, j1;
};

class Cover {
 public:
  Cover(const Reach& reach, double lever, const std::function<bool(const ShareCell&)>& is_clear)
      : path_{reach.path_spread / kPathGap},
        turn_{reach.turn_spread * lever / kTurnGap},
        is_clear_{is_clear} {}

  bool covers(const Square& square) {
    const double path = path_ * (square.i1 - square.i0) / kDivisions;
    const double turn = turn_ * (square.j1 - square.j0) / kDivisions;
    if (path <= 1.0 && turn <= 1.0) return corners_clear(square);
    if (whole_clear(square)) return true;
    if (!corners_clear(square)) return false;
    return path > turn ? halves_along_v(square) : halves_along_w(square);
  }

 private:
  bool halves_along_v(const Square& square) {
    const int middle = (square.i0 + square.i1) / 2;
    if (middle == square.i0) return false;
    return covers({square.i0, middle, square.j0, square.j1}) &&
           covers({middle, square.i1, square.j0, square.j1});
  }
  bool halves_along_w(const Square& square) {
    const int middle = (square.j0 + square.j1) / 2;
    if (middle == square.j0) return false;
    return covers({square.i0, square.i1, square.j0, middle}) &&
           covers({square.i0, square.i1, middle, square.j1});
  }
  bool corners_clear(const Square& square) {
    return corner_clear(square.i0, square.j0) && corner_clear(square.i1, square.j1) &&
           corner_clear(square.i0, square.j1) && corner_clear(square.i1, square.j0);
  }
  bool corner_clear(int i, int j) {
    auto known = known_clear_[static_cast<std::size_t>(i * (kDivisions + 1) + j)];
    if (!known) known = check({{share(i), share(j)}});
    return known;
  }
  bool whole_clear(const Square& square) {
    const auto [i0, i1, j0, j1] = square;
    return check({{0.5 * (share(i0) + share(i1)), 0.5 * (share(j0) + share(j1))},
                  {0.5 * (share(i1) - share(i0)), 0.5 * (share(j1) - share(j0))}});
  }
  bool check(const ShareCell& cell) { return ++checks_ <= kMaxChecks && is_clear_(cell); }
  static double share(int i) { return static_cast<double>(i) / kDivisions; }

  double path_, turn_;  // spread of the whole square, in units of the gaps
  const std::function<bool(const ShareCell&)>& is_clear_;
  std::bitset<static_cast<std::size_t>((kDivisions + 1) * (kDivisions + 1))> known_clear_;
  int checks_ = 0;
};

}  // namespace

bool all_motions_clear(const Reach& reach, double lever,
                       const std::function<bool(const ShareCell&)>& is_clear) {
  return Cover{reach, lever, is_clear}.covers({0, kDivisions, 0, kDivisions});
}

}  // namespace tandem
