// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/lost_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <unordered_map>
#include <utility>

#include "tandem/local_planner/ocp/signed_distance.hpp"

namespace tandem::test {
namespace {

bool has_free_cells(const Grid& grid) {
  return std::find(grid.cells.begin(), grid.cells.end(), Cell::kFree) != grid.cells.end();
}

// Shapes by squares of 1 m, each in all that it may touch.
class ShapeIndex {
 public:
  explicit ShapeIndex(const std::vector<Obstacle>& shapes, double reach) : reach_{reach} {
    for (const Obstacle& shape : shapes) {
      const Eigen::Vector2d low = shape.p_MO.array() - shape.a - reach;
      const Eigen::Vector2d high = shape.p_MO.array() + shape.a + reach;
      for (double y = std::floor(low.y()); y <= high.y(); y += 1.0)
        for (double x = std::floor(low.x()); x <= high.x(); x += 1.0)
          squares_[key({x, y})].push_back(shape);
    }
  }
  [[nodiscard]] const std::vector<Obstacle>& at(const Eigen::Vector2d& p) const {
    static const std::vector<Obstacle> none;
    const auto entry = squares_.find(key(p));
    return entry == squares_.end() ? none : entry->second;
  }
  [[nodiscard]] bool touches(const Footprint& footprint, const Pose2& X_MB) const {
    const auto& shapes = at(X_MB.position());
    return std::any_of(shapes.begin(), shapes.end(), [&](const Obstacle& shape) {
      return (shape.p_MO - X_MB.position()).norm() < shape.a + reach_ &&
             overlaps(footprint, X_MB, shape);
    });
  }
  [[nodiscard]] bool touches(const std::vector<Disc>& discs, const Pose2& X_MB) const {
    const auto& shapes = at(X_MB.position());
    return std::any_of(shapes.begin(), shapes.end(), [&](const Obstacle& shape) {
      return std::any_of(discs.begin(), discs.end(), [&](const Disc& disc) {
        return signed_distance(shape, transform(X_MB, disc.p_BC)).value < disc.radius;
      });
    });
  }

 private:
  static std::int64_t key(const Eigen::Vector2d& p) {
    return (static_cast<std::int64_t>(std::floor(p.y())) << 32) +
           static_cast<std::int64_t>(std::floor(p.x()));
  }

  double reach_;
  std::unordered_map<std::int64_t, std::vector<Obstacle>> squares_;
};

std::vector<Obstacle> all_shapes(const std::shared_ptr<const StaticMap>& map,
                                 const ExtractorParams& params, const Eigen::Vector2d& p_MS) {
  ExtractorParams everywhere = params;
  everywhere.range = 50.0;
  return extract(*map, p_MS, everywhere);
}

}  // namespace

ReachablePoses::ReachablePoses(std::shared_ptr<const StaticMap> map, Footprint footprint,
                               const Eigen::Vector2d& p_MS)
    : map_{std::move(map)}, steps_(kHeadings * map_->grid().cells.size(), -1) {
  const StaticMap known(map_->grid(), has_free_cells(map_->grid()));
  std::vector<std::int8_t> free(steps_.size(), -1);
  const auto is_free = [&](std::size_t state) {
    if (free[state] < 0) free[state] = known.clearance(footprint, pose(state), 0.01) > 0.0 ? 1 : 0;
    return free[state] > 0;
  };
  std::size_t start = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t state = 0; state < steps_.size(); ++state)
    if (const double d = (pose(state).position() - p_MS).norm(); d < nearest && is_free(state)) {
      nearest = d;
      start = state;
    }
  steps_[start] = 0;
  reached_.push_back(start);
  for (std::size_t next = 0; next < reached_.size(); ++next) {
    const std::size_t from = reached_[next];
    for_neighbours(from, [&](std::size_t to) {
      if (steps_[to] >= 0 || !is_free(to)) return;
      steps_[to] = steps_[from] + 1;
      reached_.push_back(to);
    });
  }
}

Pose2 ReachablePoses::pose(std::size_t state) const {
  const Grid& grid = map_->grid();
  const auto cell = state / kHeadings, width = static_cast<std::size_t>(grid.width);
  const Eigen::Vector2d p =
      grid.center(static_cast<int>(cell % width), static_cast<int>(cell / width));
  return {p.x(), p.y(),
          2.0 * std::numbers::pi / kHeadings * static_cast<double>(state % kHeadings)};
}

template <class Visit>
void ReachablePoses::for_neighbours(std::size_t state, const Visit& visit) const {
  const Grid& grid = map_->grid();
  const std::size_t cell = state / kHeadings, heading = state % kHeadings;
  visit(cell * kHeadings + (heading + 1) % kHeadings);
  visit(cell * kHeadings + (heading + kHeadings - 1) % kHeadings);
  const auto width = static_cast<std::size_t>(grid.width);
  const int ix = static_cast<int>(cell % width), iy = static_cast<int>(cell / width);
  for (const auto& [dx, dy] :
       std::array<std::pair<int, int>, 4>{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}})
    if (grid.contains(ix + dx, iy + dy)) visit(grid.index(ix + dx, iy + dy) * kHeadings + heading);
}

Eigen::Vector2d ReachablePoses::start() const { return pose(reached_.front()).position(); }

std::size_t ReachablePoses::nearest(const Eigen::Vector2d& p_MQ) const {
  return *std::min_element(reached_.begin(), reached_.end(), [&](std::size_t a, std::size_t b) {
    return (pose(a).position() - p_MQ).squaredNorm() < (pose(b).position() - p_MQ).squaredNorm();
  });
}

std::vector<Eigen::Vector2d> ReachablePoses::way_to(const Eigen::Vector2d& p_MZ,
                                                    double spacing) const {
  std::vector<Eigen::Vector2d> way;
  std::size_t at = nearest(p_MZ);
  way.push_back(pose(at).position());
  while (steps_[at] > 0) {
    std::size_t before = at;
    for_neighbours(at, [&](std::size_t to) {
      if (steps_[to] == steps_[at] - 1) before = to;
    });
    at = before;
    if ((pose(at).position() - way.back()).norm() >= spacing) way.push_back(pose(at).position());
  }
  return way;
}

Eigen::Vector2d ReachablePoses::some_place(unsigned number) const {
  std::mt19937 random{number};
  return pose(reached_[random() % reached_.size()]).position();
}

void Loss::add(const Loss& other) {
  poses += other.poses;
  lost += other.lost;
  lost_to_discs += other.lost_to_discs;
  shapes.insert(shapes.end(), other.shapes.begin(), other.shapes.end());
}

int Loss::shapes_at(double share) const {
  std::vector<int> sorted = shapes;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double Loss::mean_shapes() const {
  return std::accumulate(shapes.begin(), shapes.end(), 0.0) / static_cast<double>(shapes.size());
}

Loss measure_loss(const std::shared_ptr<const StaticMap>& map, const Footprint& footprint,
                  const ReachablePoses& reachable, const std::vector<Eigen::Vector2d>& goals,
                  const ExtractorParams& params, double disc_overhang) {
  const ShapeIndex shapes(all_shapes(map, params, reachable.start()), circumradius(footprint));
  const auto counts =
      reachable.count([&](const Pose2& X_MB) { return shapes.touches(footprint, X_MB); });
  std::vector<ReachablePoses::Count> disc_counts(counts.size());
  if (disc_overhang > 0.0) {
    const auto cover = cover_by_discs(footprint, disc_overhang);
    disc_counts = reachable.count([&](const Pose2& X_MB) { return shapes.touches(cover, X_MB); });
  }
  const Grid& grid = map->grid();
  ExtractorParams near = params;
  near.range = kNear;
  Extractor extractor(map, near);
  const int reach = static_cast<int>(kNear / grid.resolution) + 1;
  Loss loss;
  for (const auto& goal : goals)
    for (const Eigen::Vector2d& p_MB : reachable.way_to(goal, 0.25)) {
      loss.shapes.push_back(static_cast<int>(extractor.near(p_MB).size()));
      const Eigen::Vector2d c = (p_MB - grid.origin) / grid.resolution;
      const int mx = static_cast<int>(c.x()), my = static_cast<int>(c.y());
      for (int iy = my - reach; iy <= my + reach; ++iy)
        for (int ix = mx - reach; ix <= mx + reach; ++ix) {
          if (!grid.contains(ix, iy) || (grid.center(ix, iy) - p_MB).norm() > kNear) continue;
          loss.poses += counts[grid.index(ix, iy)].reachable;
          loss.lost += counts[grid.index(ix, iy)].lost;
          loss.lost_to_discs += disc_counts[grid.index(ix, iy)].lost;
        }
    }
  return loss;
}

}  // namespace tandem::test
