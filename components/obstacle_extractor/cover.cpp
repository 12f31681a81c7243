// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/cover.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "obstacle_extractor/ellipse_fit.hpp"

namespace tandem {
namespace {

constexpr double kJoinGap = 0.4;      // [m] parts farther apart are not tried together
constexpr double kCircleBonus = 0.3;  // of a shape: a circle counts as so much less in (1)
constexpr double kTightShare = 0.1;   // of `space_per_shape`: parts are split until they take less

constexpr double kLeastGain = 0.02;  // of (1): what a rearrangement must save
constexpr int kRounds = 6;
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

struct Part {
  std::vector<CellIndex> cells;  // none: joined into another
  Points hull;
  EllipseFit fit;
  Eigen::Vector2d low, high;  // of the hull [m]
};

Points corners(const Grid& grid, const CellIndex& cell) {
  const Eigen::Vector2d low = grid.origin + grid.resolution * Eigen::Vector2d(cell.ix, cell.iy);
  const double r = grid.resolution;
  return {low, {low.x() + r, low.y()}, {low.x() + r, low.y() + r}, {low.x(), low.y() + r}};
}

class Coverer {
 public:
  Coverer(const Grid& grid, const FreeSpace& space, const CoverParams& params)
      : grid_{grid}, space_{space}, params_{params} {}

  void split(std::vector<CellIndex> cells) {
    Part part = make(cells, convex_hull(all_corners(cells)), kTightShare * params_.space_per_shape);
    if (cells.size() == 1 || part.fit.found) {
      parts_.push_back(std::move(part));
      return;
    }
    const auto middle = halve(cells, part.fit.length_angle);
    split({cells.begin(), middle});
    split({middle, cells.end()});
  }

  // Joins the pair that lowers (1) most, until none does.
  void join() {
    for (std::size_t i = 0; i < parts_.size(); ++i) try_with_earlier(i);
    while (!joins_.empty()) {
      const auto best =
          std::max_element(joins_.begin(), joins_.end(), [](const Join& a, const Join& b) {
            return a.gain != b.gain ? a.gain < b.gain : std::tie(a.i, a.j) > std::tie(b.i, b.j);
          });
      Join join = std::move(*best);
      std::erase_if(joins_, [&](const Join& other) {
        return other.i == join.i || other.i == join.j || other.j == join.i || other.j == join.j;
      });
      for (const std::size_t old : {join.i, join.j}) {
        auto& cells = parts_[old].cells;
        join.both.cells.insert(join.both.cells.end(), cells.begin(), cells.end());
        cells.clear();
      }
      parts_.push_back(std::move(join.both));
      try_with_earlier(parts_.size() - 1);
    }
    std::erase_if(parts_, [](const Part& part) { return part.cells.empty(); });
  }

  // Halves a part and gives each half to the neighbour, or leaves it alone, whichever lowers (1)
  // most, until nothing does.
  void rearrange() {
    for (int round = 0, changes = 1; round < kRounds && changes > 0; ++round) {
      changes = 0;
      for (std::size_t i = 0; i < parts_.size(); ++i)
        if (!parts_[i].cells.empty() && (move_halves(i, 0.0) || move_halves(i, 0.5))) ++changes;
    }
    std::erase_if(parts_, [](const Part& part) { return part.cells.empty(); });
  }

  // Gives every cell to the largest shape that contains it; shapes left without cells go, those
  // left with fewer are fitted again.
  [[nodiscard]] std::vector<CoverShape> shapes() {
    std::vector<std::size_t> order(parts_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
      return parts_[i].cells.size() > parts_[j].cells.size();
    });
    std::vector<std::vector<CellIndex>> cells_of(parts_.size());
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (const CellIndex& cell : parts_[i].cells)
        cells_of[*std::find_if(order.begin(), order.end(), [&](std::size_t owner) {
          return owner == i || contains(parts_[owner], cell);
        })].push_back(cell);
    std::vector<CoverShape> result;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (!cells_of[i].empty()) result.push_back(shape(fit_again(i, cells_of[i]), cells_of[i]));
    return result;
  }

 private:
  struct Join {
    std::size_t i, j;
    double gain;
    Part both;
  };

  [[nodiscard]] double cost(const Part& part) const {
    return 1.0 + part.fit.price / params_.space_per_shape;  // (1)
  }

  // Where a half of a part goes: to part `to`, or (to = none) stays a part of its own.
  struct Move {
    double cost = std::numeric_limits<double>::infinity();  // more than now
    std::size_t to = kNone;
    Part part;
  };

  // The best two moves of a half, to different parts.
  [[nodiscard]] std::array<Move, 2> moves(const std::vector<CellIndex>& cells, std::size_t from,
                                          double most) const {
    std::array<Move, 2> best;
    const auto consider = [&](Move move) {
      if (move.cost < best[0].cost) std::swap(move, best[0]);
      if (move.cost < best[1].cost) std::swap(move, best[1]);
    };
    const double price = most * params_.space_per_shape;
    Part alone = make(cells, convex_hull(all_corners(cells)), price);
    for (std::size_t j = 0; j < parts_.size(); ++j) {
      if (j == from || parts_[j].cells.empty() || !neighbours(parts_[j], alone)) continue;
      Points points = parts_[j].hull;
      points.insert(points.end(), alone.hull.begin(), alone.hull.end());
      Part both = make({}, convex_hull(std::move(points)), parts_[j].fit.price + price);
      if (both.fit.found) consider({cost(both) - cost(parts_[j]), j, std::move(both)});
    }
    if (alone.fit.found) consider({cost(alone), kNone, std::move(alone)});
    return best;
  }

  [[nodiscard]] bool move_halves(std::size_t i, double turn) {
    std::vector<CellIndex> cells = parts_[i].cells;
    if (cells.size() < 2) return false;
    const auto middle = halve(cells, parts_[i].fit.length_angle + turn * std::numbers::pi);
    const std::vector<CellIndex> first{cells.begin(), middle}, second{middle, cells.end()};
    const double now = cost(parts_[i]) - kLeastGain;
    auto a = moves(first, i, now), b = moves(second, i, now);
    double least = now;
    std::pair<int, int> best{-1, -1};
    for (int m = 0; m < 2; ++m)
      for (int n = 0; n < 2; ++n) {
        const Move &one = a[static_cast<std::size_t>(m)], &two = b[static_cast<std::size_t>(n)];
        if (one.to == two.to && one.to != kNone) continue;
        if (one.cost + two.cost < least) {
          least = one.cost + two.cost;
          best = {m, n};
        }
      }
    if (best.first < 0) return false;
    parts_[i].cells.clear();
    apply(std::move(a[static_cast<std::size_t>(best.first)]), first);
    apply(std::move(b[static_cast<std::size_t>(best.second)]), second);
    return true;
  }

  void apply(Move move, const std::vector<CellIndex>& cells) {
    if (move.to != kNone) {
      move.part.cells = std::move(parts_[move.to].cells);
      move.part.cells.insert(move.part.cells.end(), cells.begin(), cells.end());
      parts_[move.to] = std::move(move.part);
    } else {
      parts_.push_back(std::move(move.part));
    }
  }

  void try_with_earlier(std::size_t j) {
    for (std::size_t i = 0; i < j; ++i) {
      if (parts_[i].cells.empty() || !neighbours(parts_[i], parts_[j])) continue;
      Points points = parts_[i].hull;
      points.insert(points.end(), parts_[j].hull.begin(), parts_[j].hull.end());
      const double now = cost(parts_[i]) + cost(parts_[j]);
      Part both = make({}, convex_hull(std::move(points)), (now - 1.0) * params_.space_per_shape);
      const double gain = now - cost(both);
      if (both.fit.found && gain > 0.0) joins_.push_back({i, j, gain, std::move(both)});
    }
  }

  [[nodiscard]] Obstacle fit_again(std::size_t i, const std::vector<CellIndex>& own) const {
    if (own.size() == parts_[i].cells.size()) return parts_[i].fit.shape;
    const Part again = make({}, convex_hull(all_corners(own)), parts_[i].fit.price);
    return again.fit.found ? again.fit.shape : parts_[i].fit.shape;
  }

  [[nodiscard]] Points all_corners(const std::vector<CellIndex>& cells) const {
    Points points;
    points.reserve(4 * cells.size());
    for (const CellIndex& cell : cells)
      for (const auto& p : corners(grid_, cell)) points.push_back(p);
    return points;
  }

  [[nodiscard]] Part make(std::vector<CellIndex> cells, Points hull, double price) const {
    Part part{std::move(cells), std::move(hull), {}, {}, {}};
    part.fit = fit_ellipse(part.hull, space_,
                           {params_.max_excess, price, kCircleBonus * params_.space_per_shape});
    part.low = part.high = part.hull[0];
    for (const auto& p : part.hull) {
      part.low = part.low.cwiseMin(p);
      part.high = part.high.cwiseMax(p);
    }
    return part;
  }

  // Sorts the cells into those before and behind the middle of their extent along `angle`.
  [[nodiscard]] std::vector<CellIndex>::iterator halve(std::vector<CellIndex>& cells,
                                                       double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    const auto along = [&](const CellIndex& cell) { return c * cell.ix + s * cell.iy; };
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const CellIndex& cell : cells) {
      low = std::min(low, along(cell));
      high = std::max(high, along(cell));
    }
    const auto middle = std::stable_partition(cells.begin(), cells.end(), [&](const auto& cell) {
      return along(cell) <= 0.5 * (low + high) + 1e-9;
    });
    if (middle != cells.begin() && middle != cells.end()) return middle;
    return cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / 2);
  }

  [[nodiscard]] static bool neighbours(const Part& p, const Part& q) {
    return (p.low.array() <= q.high.array() + kJoinGap).all() &&
           (q.low.array() <= p.high.array() + kJoinGap).all();
  }

  [[nodiscard]] bool contains(const Part& part, const CellIndex& cell) const {
    const Points square = corners(grid_, cell);
    return std::all_of(square.begin(), square.end(),
                       [&](const Eigen::Vector2d& p) { return level(part.fit.shape, p) <= 1.0; });
  }

  [[nodiscard]] CoverShape shape(Obstacle obstacle, const std::vector<CellIndex>& cells) const {
    CoverShape result{obstacle, grid_.center(cells[0].ix, cells[0].iy), {}};
    result.high = result.low;
    std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
    for (const CellIndex& cell : cells) {
      lowest = std::min(lowest, static_cast<std::int64_t>(cell.iy) * grid_.width + cell.ix);
      result.low = result.low.cwiseMin(grid_.center(cell.ix, cell.iy));
      result.high = result.high.cwiseMax(grid_.center(cell.ix, cell.iy));
    }
    result.obstacle.id = static_cast<std::uint32_t>(lowest + 1);
    result.low.array() -= 0.5 * grid_.resolution;
    result.high.array() += 0.5 * grid_.resolution;
    return result;
  }

  const Grid& grid_;
  const FreeSpace& space_;
  CoverParams params_;
  std::vector<Part> parts_;
  std::vector<Join> joins_;
};

}  // namespace

std::vector<CoverShape> cover(const Grid& grid, const std::vector<std::vector<CellIndex>>& clusters,
                              const FreeSpace& space, const CoverParams& params) {
  Coverer coverer(grid, space, params);
  for (const auto& cells : clusters) coverer.split(cells);
  coverer.join();
  coverer.rearrange();
  return coverer.shapes();
}

}  // namespace tandem
