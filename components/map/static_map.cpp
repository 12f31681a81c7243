// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/static_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "tandem/map/distance_transform.hpp"

namespace tandem {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check(const Grid& grid) {
  if (!(grid.resolution > 0.0) || !std::isfinite(grid.resolution) || !grid.origin.allFinite())
    throw std::invalid_argument("grid: resolution and origin must be finite, resolution > 0");
  if (grid.width < 0 || grid.height < 0 ||
      grid.cells.size() !=
          static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height))
    throw std::invalid_argument("grid: width × height differs from the number of cells");
}

bool counts(Cell cell, bool unknown_is_obstacle) {
  return cell == Cell::kOccupied || (unknown_is_obstacle && cell == Cell::kUnknown);
}

// The largest float that does not exceed the value, which is not negative. Without a call, so that
// the compiler can do several at once.
float round_down(double value) {
  const auto rounded = static_cast<float>(value);
  const auto bits = std::bit_cast<std::uint32_t>(rounded);
  return std::bit_cast<float>(bits - (static_cast<double>(rounded) > value ? 1U : 0U));
}

// Axis-parallel box.
struct Box {
  Eigen::Vector2d low{kInfinity, kInfinity}, high{-kInfinity, -kInfinity};

  void add(const Eigen::Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  [[nodiscard]] double distance(const Eigen::Vector2d& p) const {
    const double dx = std::max({0.0, low.x() - p.x(), p.x() - high.x()});
    const double dy = std::max({0.0, low.y() - p.y(), p.y() - high.y()});
    return std::sqrt(dx * dx + dy * dy);
  }
};

// Indices of the cells that an interval [low, high] of cell coordinates touches, clipped to [0,
// size).
struct Span {
  int begin, end;
};
Span cells_between(double low, double high, int size) {
  const auto limit = [size](double value) {
    return static_cast<int>(std::clamp(std::floor(value), -1.0, static_cast<double>(size)));
  };
  return {std::max(0, limit(low)), std::min(size, limit(high) + 1)};
}

// Side length in cells, a power of two, of the smallest block that holds both spans.
int block_of(const Span& columns, const Span& rows) {
  int cells = 1;
  while (cells < columns.end - columns.begin || cells < rows.end - rows.begin) cells *= 2;
  return cells;
}

// A part of the outline at a pose, prepared for distance queries to many squares.
class PlacedPart {
 public:
  PlacedPart(const ConvexPolygon& part, const Pose2& X_MB)
      : part_{part}, X_MB_{X_MB}, c_{std::cos(X_MB.theta)}, s_{std::sin(X_MB.theta)} {
    for (const auto& p_BV : part) {
      in_body_.add(p_BV);
      in_map_.add(to_map(p_BV));
    }
  }

  [[nodiscard]] const Box& box() const { return in_map_; }

  // Lower bound on the clearance, from three discs along the longer side of the box in B.
  [[nodiscard]] double bound(const StaticMap& map) const {
    const Eigen::Vector2d size = in_body_.high - in_body_.low;
    const int axis = size.x() >= size.y() ? 0 : 1;
    const double radius = std::hypot(size[axis] / 6.0, 0.5 * size[1 - axis]);
    Eigen::Vector2d p_BC = 0.5 * (in_body_.low + in_body_.high);
    const double middle = p_BC[axis];
    double bound = kInfinity;
    for (const double shift : {0.0, 1.0, -1.0}) {
      p_BC[axis] = middle + shift * size[axis] / 3.0;
      bound = std::min(bound, map.distance(to_map(p_BC)) - radius);
    }
    return bound;
  }

  // Lower bound on the distance to the square of side `side` around p_MC: the distance between both
  // bounding boxes in B's axes. Exact for a rectangle parallel to the grid.
  [[nodiscard]] double bound(const Eigen::Vector2d& p_MC, double side) const {
    const double x = p_MC.x() - X_MB_.x, y = p_MC.y() - X_MB_.y;
    const double reach = 0.5 * side * (std::abs(c_) + std::abs(s_));
    const Eigen::Vector2d p_BC{c_ * x + s_ * y, -s_ * x + c_ * y};
    const double dx = std::max({0.0, in_body_.low.x() - p_BC.x(), p_BC.x() - in_body_.high.x()});
    const double dy = std::max({0.0, in_body_.low.y() - p_BC.y(), p_BC.y() - in_body_.high.y()});
    const double gx = std::max(0.0, dx - reach), gy = std::max(0.0, dy - reach);
    return std::sqrt(gx * gx + gy * gy);
  }

  [[nodiscard]] double distance(const Eigen::Vector2d& p_MC, double side) const {
    return distance_to_square(part_, X_MB_, p_MC, side);
  }

 private:
  [[nodiscard]] Eigen::Vector2d to_map(const Eigen::Vector2d& p) const {
    return {X_MB_.x + c_ * p.x() - s_ * p.y(), X_MB_.y + s_ * p.x() + c_ * p.y()};
  }

  const ConvexPolygon& part_;
  Pose2 X_MB_;
  double c_, s_;
  Box in_body_, in_map_;
};

// Branch and bound over square blocks of cells for the obstacle nearest to an outline.
struct NearestCell {
  const StaticMap& map;
  const PlacedPart& outline;
  double best;    // [m] smallest distance so far
  double search;  // [m] cells farther than this cannot be nearest

  // Visits the block of `cells` × `cells` that starts at (ix, iy).
  void visit(int ix, int iy, int cells) {
    if (!map.may_hold_obstacle(ix, iy, cells)) return;
    const double side = map.grid().resolution, half = 0.5 * (cells - 1) * side;
    const Eigen::Vector2d p_MC = map.grid().center(ix, iy) + Eigen::Vector2d(half, half);
    if (outline.bound(p_MC, cells * side) >= search) return;
    if (cells == 1) {
      best = std::min(best, outline.distance(p_MC, side));
      search = std::min(search, best);
      return;
    }
    const int h = cells / 2;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {h, 0}, {0, h}, {h, h}})
      visit(ix + dx, iy + dy, h);
  }
};

}  // namespace

StaticMap::StaticMap(Grid grid, bool unknown_is_obstacle)
    : grid_{std::move(grid)}, unknown_is_obstacle_{unknown_is_obstacle} {
  check(grid_);
  cells_per_metre_ = 1.0 / grid_.resolution;
  std::vector<std::uint8_t> obstacles(grid_.cells.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    obstacles[i] = counts(grid_.cells[i], unknown_is_obstacle) ? 1 : 0;
  const std::vector<double> cells = distance_transform(obstacles, grid_.width, grid_.height);
  distance_.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    distance_[i] = round_down(grid_.resolution * cells[i]);
  if (unknown_is_obstacle_) limit_to_border();
}

// Outside the grid everything is unknown.
void StaticMap::limit_to_border() {
  std::size_t i = 0;
  for (int iy = 0; iy < grid_.height; ++iy)
    for (int ix = 0; ix < grid_.width; ++ix, ++i) {
      const int to_border = std::min({ix, iy, grid_.width - 1 - ix, grid_.height - 1 - iy});
      distance_[i] = std::min(distance_[i], round_down(grid_.resolution * (to_border + 0.5)));
    }
}

bool StaticMap::is_obstacle(int ix, int iy) const {
  return grid_.contains(ix, iy) ? counts(grid_.at(ix, iy), unknown_is_obstacle_)
                                : unknown_is_obstacle_;
}

bool StaticMap::may_hold_obstacle(int ix, int iy, int cells) const {
  if (ix >= grid_.width || iy >= grid_.height) return false;
  const int half = cells / 2, mx = ix + half, my = iy + half;
  if (mx >= grid_.width || my >= grid_.height) return true;
  // From the middle cell's centre to the square of the farthest cell, along both axes.
  const double farthest = std::max(0.0, half - 0.5) * std::numbers::sqrt2 * grid_.resolution;
  return static_cast<double>(field(mx, my)) <= farthest;
}

float StaticMap::field(int ix, int iy) const {
  return distance_[static_cast<std::size_t>(iy) * static_cast<std::size_t>(grid_.width) +
                   static_cast<std::size_t>(ix)];
}

double StaticMap::distance(const Eigen::Vector2d& p_MQ) const {
  const double x = (p_MQ.x() - grid_.origin.x()) * cells_per_metre_;
  const double y = (p_MQ.y() - grid_.origin.y()) * cells_per_metre_;
  if (x >= 0.0 && y >= 0.0 && x < grid_.width && y < grid_.height) {
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    const double dx = x - ix - 0.5, dy = y - iy - 0.5;
    const double off_center = grid_.resolution * std::sqrt(dx * dx + dy * dy);
    return std::max(0.0, static_cast<double>(field(ix, iy)) - off_center);
  }
  if (unknown_is_obstacle_ || !p_MQ.allFinite()) return 0.0;
  if (distance_.empty()) return kInfinity;
  // The grid is convex: seen from its nearest point q, every obstacle lies at a right angle or
  // more from p, so |p − o|² ≥ |p − q|² + |q − o|².
  const double qx = std::clamp(x, 0.0, std::nextafter(static_cast<double>(grid_.width), 0.0));
  const double qy = std::clamp(y, 0.0, std::nextafter(static_cast<double>(grid_.height), 0.0));
  const int ix = static_cast<int>(qx), iy = static_cast<int>(qy);
  const double off_center = grid_.resolution * std::hypot(qx - ix - 0.5, qy - iy - 0.5);
  const double inside = std::max(0.0, static_cast<double>(field(ix, iy)) - off_center);
  return std::hypot(inside, grid_.resolution * std::hypot(x - qx, y - qy));
}

double StaticMap::clearance(const Footprint& footprint, const Pose2& X_MB, double cap) const {
  if (!is_finite(X_MB)) return 0.0;
  double least = cap;
  for (const auto& part : footprint.parts) {
    least = part_clearance(part, X_MB, least);
    if (least <= 0.0) break;
  }
  return least;
}

double StaticMap::part_clearance(const ConvexPolygon& part, const Pose2& X_MB, double cap) const {
  const PlacedPart outline(part, X_MB);
  if (outline.bound(*this) >= cap) return cap;

  // The part's box in cells.
  const Eigen::Vector2d low = (outline.box().low - grid_.origin) * cells_per_metre_;
  const Eigen::Vector2d high = (outline.box().high - grid_.origin) * cells_per_metre_;
  double best = cap;
  if (unknown_is_obstacle_) {  // everything outside the grid is an obstacle too
    const double gap =
        std::min({low.x(), low.y(), grid_.width - high.x(), grid_.height - high.y()});
    best = std::min(best, grid_.resolution * std::max(0.0, gap));
  }
  NearestCell nearest{*this, outline, best, std::min(best, most_clearance(X_MB.position()))};
  const double reach = nearest.search * cells_per_metre_;
  const Span columns = cells_between(low.x() - reach, high.x() + reach, grid_.width);
  const Span rows = cells_between(low.y() - reach, high.y() + reach, grid_.height);
  nearest.visit(columns.begin, rows.begin, block_of(columns, rows));
  return nearest.best;
}

double StaticMap::clearance_bound(const Footprint& footprint, const Pose2& X_MB) const {
  if (!is_finite(X_MB)) return 0.0;
  double bound = kInfinity;
  for (const auto& part : footprint.parts)
    bound = std::min(bound, PlacedPart(part, X_MB).bound(*this));
  return std::max(0.0, bound);
}

double StaticMap::most_clearance(const Eigen::Vector2d& p_MB) const {
  const Eigen::Vector2d c = (p_MB - grid_.origin) * cells_per_metre_;
  const bool inside = c.x() >= 0.0 && c.y() >= 0.0 && c.x() < grid_.width && c.y() < grid_.height;
  return inside ? distance(p_MB) + 1.5 * grid_.resolution : kInfinity;
}

std::vector<Eigen::Vector2d> StaticMap::cells_near(const Eigen::Vector2d& p_MQ,
                                                   double radius) const {
  return cells_near(p_MQ, radius, 0);
}

std::vector<Eigen::Vector2d> StaticMap::squares_near(const Eigen::Vector2d& p_MQ,
                                                     double radius) const {
  return cells_near(p_MQ, radius, unknown_is_obstacle_ ? 1 : 0);
}

std::vector<Eigen::Vector2d> StaticMap::cells_near(const Eigen::Vector2d& p_MQ, double radius,
                                                   int ring) const {
  std::vector<Eigen::Vector2d> centers;
  if (!p_MQ.allFinite() || !(radius >= 0.0)) return centers;
  const Eigen::Vector2d middle = (p_MQ - grid_.origin) * cells_per_metre_;
  const double reach = radius * cells_per_metre_ + 1.0;
  const Span columns =
      cells_between(middle.x() - reach + ring, middle.x() + reach + ring, grid_.width + 2 * ring);
  const Span rows =
      cells_between(middle.y() - reach + ring, middle.y() + reach + ring, grid_.height + 2 * ring);
  const double half = 0.5 * grid_.resolution;
  for (int iy = rows.begin - ring; iy < rows.end - ring; ++iy)
    for (int ix = columns.begin - ring; ix < columns.end - ring; ++ix) {
      if (!is_obstacle(ix, iy)) continue;
      const Eigen::Vector2d p_MC = grid_.center(ix, iy);
      const Box square{p_MC.array() - half, p_MC.array() + half};
      if (square.distance(p_MQ) <= radius) centers.push_back(p_MC);
    }
  return centers;
}

bool StaticMap::can_pass(const Eigen::Vector2d& p_MA, const Eigen::Vector2d& p_MZ,
                         double radius) const {
  const auto cell = [&](const Eigen::Vector2d& p) -> std::optional<std::pair<int, int>> {
    const Eigen::Vector2d c = (p - grid_.origin) * cells_per_metre_;
    if (!(c.x() >= 0.0 && c.y() >= 0.0 && c.x() < grid_.width && c.y() < grid_.height)) return {};
    return std::pair{static_cast<int>(c.x()), static_cast<int>(c.y())};
  };
  const auto from = cell(p_MA), to = cell(p_MZ);
  if (!from || !to) return false;
  std::vector<std::uint8_t> seen(grid_.cells.size());
  std::vector<std::pair<int, int>> open;
  const auto visit = [&](int ix, int iy) {
    // Halfway to the next cell's centre the disc can be half a cell nearer to an obstacle.
    if (!grid_.contains(ix, iy) ||
        static_cast<double>(field(ix, iy)) < radius + 0.5 * grid_.resolution)
      return;
    auto& mark = seen[static_cast<std::size_t>(iy) * static_cast<std::size_t>(grid_.width) +
                      static_cast<std::size_t>(ix)];
    if (std::exchange(mark, std::uint8_t{1}) == 0) open.emplace_back(ix, iy);
  };
  visit(from->first, from->second);
  while (!open.empty()) {
    const auto at = open.back();
    if (at == *to) return true;
    open.pop_back();
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      visit(at.first + dx, at.second + dy);
  }
  return false;
}

}  // namespace tandem
