// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/cover.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "tandem/obstacle_extractor/cover/cover_part.hpp"

namespace tandem {
namespace {

constexpr double kTightShare = 0.1;  // of `space_per_shape`: parts that take more are split

constexpr double kLeastGain = 0.005;  // of (1): minimum gain of a rearrangement
constexpr int kRounds = 6;
constexpr int kLevels = 16;      // of coarseness
constexpr int kGuards = 8;       // maximum number of attempts to keep passages open
constexpr double kNearly = 1.2;  // times `crowded`: rearranging more is too slow
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// A cut of one part: its direction relative to straight across the part's length, and its position
// as a fraction of the extent.
struct Cut {
  double turn, fraction;  // turn: [rad]
};
constexpr double kQuarter = std::numbers::pi / 4.0;
constexpr std::array<Cut, 8> kCuts{{{0.0, 0.5},
                                    {2.0 * kQuarter, 0.5},
                                    {kQuarter, 0.5},
                                    {3.0 * kQuarter, 0.5},
                                    {0.0, 0.25},
                                    {0.0, 0.75},
                                    {2.0 * kQuarter, 0.25},
                                    {2.0 * kQuarter, 0.75}}};
constexpr double kWaste = 0.04;  // of (1) beyond two ellipses: with less waste no cut is tried
// Directions and positions tried when two parts are cut together.
constexpr int kTurns = 6, kFractions = 5;

class Coverer {
 public:
  explicit Coverer(const PartFitter& fitter, std::vector<CoverPart> parts = {})
      : fitter_{fitter}, parts_{std::move(parts)} {}

  [[nodiscard]] const std::vector<CoverPart>& parts() const { return parts_; }

  void split(Cells cells) {
    CoverPart part = fitter_.fit(std::move(cells), 1.0 + kTightShare);
    if (part.cells.size() == 1 || part.fit.found) {
      parts_.push_back(std::move(part));
      return;
    }
    const auto middle = fitter_.cut(part.cells, smallest_box(part.outline->hull).angle, 0.5);
    split({part.cells.begin(), middle});
    split({middle, part.cells.end()});
  }

  // Joins the pair that lowers (1) most until no pair lowers it.
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
        Cells& cells = parts_[old].cells;
        join.both.cells.insert(join.both.cells.end(), cells.begin(), cells.end());
        cells.clear();
      }
      parts_.push_back(std::move(join.both));
      try_with_earlier(parts_.size() - 1);
    }
    forget_empty();
  }

  // Lowers (1) until nothing does: cuts the union of two neighbours at another place, or cuts a
  // part in two pieces, each of which joins a neighbour or becomes its own part.
  void rearrange() {
    for (CoverPart& part : parts_) part.changed = 0;
    for (round_ = 0; round_ < kRounds; ++round_) {
      for (std::size_t i = 0; i < parts_.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          if (are_neighbours(i, j) && (is_new(parts_[i]) || is_new(parts_[j]))) cut_together(i, j);
      for (std::size_t i = 0; i < parts_.size(); ++i)
        if (is_surrounding_new(i))
          for (const Cut& cut : kCuts)
            if (parts_[i].cells.size() > 1) move_pieces(i, cut);
      forget_empty();
      if (std::none_of(parts_.begin(), parts_.end(),
                       [&](const CoverPart& part) { return part.changed > round_; }))
        break;
    }
  }

  // Assigns every cell to the largest shape that contains it. Shapes left without cells are
  // dropped, those left with fewer cells are refitted.
  [[nodiscard]] std::vector<CoverShape> shapes() const {
    std::vector<std::size_t> order(parts_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
      return parts_[i].cells.size() > parts_[j].cells.size();
    });
    std::vector<Cells> cells_of(parts_.size());
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (const CellIndex& cell : parts_[i].cells)
        cells_of[*std::find_if(order.begin(), order.end(), [&](std::size_t owner) {
          return owner == i || fitter_.contains(parts_[owner], cell);
        })].push_back(cell);
    std::vector<CoverShape> result;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (!cells_of[i].empty())
        result.push_back(fitter_.shape(of_cells(i, std::move(cells_of[i]))));
    return result;
  }

 private:
  struct Join {
    std::size_t i, j;
    double gain;
    CoverPart both;
  };

  // Target of a piece of a part: part `to`, or kNone for a new part.
  struct Move {
    double cost = std::numeric_limits<double>::infinity();  // increase of (1)
    std::size_t to = kNone;
    CoverPart part;
  };

  [[nodiscard]] bool are_neighbours(std::size_t i, std::size_t j) const {
    return i != j && !parts_[i].cells.empty() && !parts_[j].cells.empty() &&
           PartFitter::neighbours(parts_[i], parts_[j]);
  }

  void forget_empty() {
    std::erase_if(parts_, [](const CoverPart& part) { return part.cells.empty(); });
  }

  void try_with_earlier(std::size_t j) {
    for (std::size_t i = 0; i < j; ++i) {
      if (!are_neighbours(i, j)) continue;
      const double now = fitter_.cost(parts_[i]) + fitter_.cost(parts_[j]);
      CoverPart both = fitter_.fit_both(parts_[i], parts_[j], now);
      const double gain = now - fitter_.cost(both);
      if (both.fit.found && gain > 0.0) joins_.push_back({i, j, gain, std::move(both)});
    }
  }

  // Whether the part changed since it was last tried; an unchanged part gives the same result.
  [[nodiscard]] bool is_new(const CoverPart& part) const { return part.changed >= round_; }

  [[nodiscard]] bool is_surrounding_new(std::size_t i) const {
    for (std::size_t j = 0; j < parts_.size(); ++j)
      if ((i == j || are_neighbours(i, j)) && is_new(parts_[j])) return true;
    return false;
  }

  void cut_together(std::size_t i, std::size_t j) {
    if (fitter_.cost(parts_[i]) + fitter_.cost(parts_[j]) < 2.0 + kWaste) return;
    Cells cells = parts_[i].cells;
    cells.insert(cells.end(), parts_[j].cells.begin(), parts_[j].cells.end());
    const double angle = parts_[i].fit.length_angle;
    double least = fitter_.cost(parts_[i]) + fitter_.cost(parts_[j]) - kLeastGain;
    for (int turn = 0; turn < kTurns; ++turn)
      for (int k = 1; k < kFractions; ++k) {
        const auto middle = fitter_.cut(cells, angle + turn * std::numbers::pi / kTurns,
                                        static_cast<double>(k) / kFractions);
        CoverPart one = fitter_.outline({cells.begin(), middle}, least - PartFitter::kLeastCost);
        if (one.least > least - PartFitter::kLeastCost) continue;
        CoverPart two = fitter_.outline({middle, cells.end()}, least - one.least);
        if (two.least > least - one.least) continue;
        fitter_.fit(one, least - two.least);
        if (!one.fit.found) continue;
        const double rest = least - fitter_.cost(one);
        fitter_.fit(two, rest);
        if (!two.fit.found || fitter_.cost(two) >= rest) continue;
        least = fitter_.cost(one) + fitter_.cost(two);
        one.changed = two.changed = round_ + 1;
        parts_[i] = std::move(one);
        parts_[j] = std::move(two);
      }
  }

  // The two cheapest moves of a piece, to different parts.
  [[nodiscard]] std::array<Move, 2> moves(const Cells& cells, std::size_t from, double most) const {
    std::array<Move, 2> best;
    const auto consider = [&](Move move) {
      if (move.cost < best[0].cost) std::swap(move, best[0]);
      if (move.cost < best[1].cost) std::swap(move, best[1]);
    };
    CoverPart alone = fitter_.fit(cells, most);
    for (std::size_t j = 0; j < parts_.size(); ++j) {
      if (j == from || parts_[j].cells.empty() || !PartFitter::neighbours(parts_[j], alone))
        continue;
      const double now = fitter_.cost(parts_[j]);
      CoverPart both = fitter_.fit_both(parts_[j], alone, now + most);
      if (both.fit.found) consider({fitter_.cost(both) - now, j, std::move(both)});
    }
    if (alone.fit.found) consider({fitter_.cost(alone), kNone, std::move(alone)});
    return best;
  }

  void move_pieces(std::size_t i, const Cut& cut) {
    Cells cells = parts_[i].cells;
    const auto middle = fitter_.cut(cells, parts_[i].fit.length_angle + cut.turn, cut.fraction);
    const Cells first{cells.begin(), middle}, second{middle, cells.end()};
    const double now = fitter_.cost(parts_[i]) - kLeastGain;
    auto a = moves(first, i, now);
    if (a[0].cost >= now) return;
    auto b = moves(second, i, now - a[0].cost);
    double least = now;
    Move *one = nullptr, *two = nullptr;
    for (Move& m : a)
      for (Move& n : b) {
        if ((m.to == n.to && m.to != kNone) || m.cost + n.cost >= least) continue;
        least = m.cost + n.cost;
        one = &m;
        two = &n;
      }
    if (one == nullptr) return;
    parts_[i].cells.clear();
    apply(std::move(*one), first);
    apply(std::move(*two), second);
  }

  void apply(Move move, const Cells& cells) {
    move.part.changed = round_ + 1;
    if (move.to != kNone) {
      move.part.cells = std::move(parts_[move.to].cells);
      move.part.cells.insert(move.part.cells.end(), cells.begin(), cells.end());
      parts_[move.to] = std::move(move.part);
    } else {
      parts_.push_back(std::move(move.part));
    }
  }

  // Part i reduced to these of its cells.
  [[nodiscard]] CoverPart of_cells(std::size_t i, Cells own) const {
    CoverPart part = parts_[i];
    const bool has_all = own.size() == part.cells.size();
    part.cells = std::move(own);
    if (has_all) return part;
    CoverPart again = fitter_.fit(part.cells, fitter_.cost(part));
    return again.fit.found ? again : part;
  }

  const PartFitter& fitter_;
  std::vector<CoverPart> parts_;
  std::vector<Join> joins_;
  int round_ = 0;  // of rearrange
};

std::vector<Obstacle> obstacles(const std::vector<CoverShape>& shapes) {
  std::vector<Obstacle> all;
  for (const CoverShape& shape : shapes) all.push_back(shape.obstacle);
  return all;
}

// Covers the same cells by at most `most` coarser shapes, if kLevels levels suffice.
std::vector<CoverShape> coarser(PartFitter fitter, const Coverer& fine, std::size_t most) {
  Coverer coverer(fitter, fine.parts());
  for (int level = 0; level < kLevels && coverer.parts().size() > most; ++level) {
    fitter.coarsen();
    coverer.join();
    if (static_cast<double>(coverer.parts().size()) <= kNearly * static_cast<double>(most))
      coverer.rearrange();
  }
  return coverer.shapes();
}

}  // namespace

std::vector<CoverShape> cover(const Grid& grid, const std::vector<std::vector<CellIndex>>& clusters,
                              const FreeSpace& space, const Passages& ways,
                              const CoverParams& params) {
  const PartFitter fitter(grid, space, params);
  Coverer fine(fitter);
  for (const auto& cells : clusters) fine.split(cells);
  fine.join();
  fine.rearrange();
  const std::vector<CoverShape> shapes = fine.shapes();
  if (fine.parts().size() <= params.crowded) return shapes;
  const auto before = obstacles(shapes);
  FreeSpace kept = space;
  for (int guard = 0; guard < kGuards; ++guard) {
    const auto fewer = coarser({grid, kept, params}, fine, params.crowded);
    const auto closed = ways.closed(before, obstacles(fewer));
    if (closed.empty()) return fewer;
    if (!kept.keep(ways.window(), closed)) break;
  }
  return shapes;  // too many shapes are better than a closed passage
}

}  // namespace tandem
