// SPDX-License-Identifier: Apache-2.0
// In: a grid. Out: what everyone asks of the static world: distance, clearance, cells nearby.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/footprint.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Static obstacles of the plane: the occupied cells (and the unknown ones, if asked for) as exact
/// squares, with a Euclidean distance field over them. Immutable; copies are cheap to avoid by
/// holding a std::shared_ptr<const StaticMap>.
class StaticMap {
 public:
  /// Throws std::invalid_argument if the grid's sizes contradict each other.
  /// `unknown_is_obstacle` also decides for everything outside of the grid.
  explicit StaticMap(Grid grid, bool unknown_is_obstacle = false);

  [[nodiscard]] const Grid& grid() const { return grid_; }
  [[nodiscard]] bool is_obstacle(int ix, int iy) const;

  /// Lower bound on the distance from a point to the nearest obstacle square [m]: never more than
  /// the true distance, and (inside the grid) less by at most √2 · resolution; 0 on an obstacle;
  /// infinite if there is none; 0 for a point that is not finite. One look-up.
  [[nodiscard]] double distance(const Eigen::Vector2d& p_MQ) const;

  /// False if the block of `cells` × `cells` from cell (ix, iy) on surely holds no obstacle of the
  /// grid. ix, iy ≥ 0. One look-up; for one cell the answer is exact.
  [[nodiscard]] bool may_hold_obstacle(int ix, int iy, int cells) const;

  /// Exact distance between the footprint at X_MB and the nearest obstacle square [m]: 0 on
  /// contact, at most `cap`. Cost grows with the obstacle cells that are
  /// about as near as the nearest.
  [[nodiscard]] double clearance(const Footprint& footprint, const Pose2& X_MB, double cap) const;

  /// Lower bound on clearance() [m], by three look-ups: less by about a third of the footprint's
  /// narrower side or less.
  [[nodiscard]] double clearance_bound(const Footprint& footprint, const Pose2& X_MB) const;

  /// Centres of the obstacle cells of the grid whose square comes within `radius` of the point.
  [[nodiscard]] std::vector<Eigen::Vector2d> cells_near(const Eigen::Vector2d& p_MQ,
                                                        double radius) const;
  /// The same, and if unknown_is_obstacle also of the row of cells around the grid: no obstacle is
  /// nearer than the nearest of them.
  [[nodiscard]] std::vector<Eigen::Vector2d> squares_near(const Eigen::Vector2d& p_MQ,
                                                          double radius) const;

  /// First obstacle along the ray from p_MQ at `heading` in M: distance [m], at most `max_range`.
  [[nodiscard]] double cast_ray(const Eigen::Vector2d& p_MQ, double heading,
                                double max_range) const;

  /// Whether a disc of that radius surely comes from one point to the other without contact, its
  /// centre going from cell to cell of the grid.
  [[nodiscard]] bool can_pass(const Eigen::Vector2d& p_MA, const Eigen::Vector2d& p_MZ,
                              double radius) const;

 private:
  [[nodiscard]] float field(int ix, int iy) const;
  // With the rows and columns beyond each side of the grid, `ring` of them.
  [[nodiscard]] std::vector<Eigen::Vector2d> cells_near(const Eigen::Vector2d& p_MQ, double radius,
                                                        int ring) const;
  // One part's clearance [m], at most `cap`; `cap` too if most_clearance() of the pose is less:
  // then the part that contains B's origin is nearer to an obstacle.
  [[nodiscard]] double part_clearance(const ConvexPolygon& part, const Pose2& X_MB,
                                      double cap) const;
  // No outline that contains the point has more clearance [m].
  [[nodiscard]] double most_clearance(const Eigen::Vector2d& p_MB) const;

  Grid grid_;
  bool unknown_is_obstacle_;
  double cells_per_metre_;
  std::vector<float> distance_;  // per cell, centre to nearest obstacle square, rounded down [m]
};

}  // namespace tandem
