// SPDX-License-Identifier: Apache-2.0
// Distance, clearance, nearby cells and ray casts in the static map.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/map/grid.hpp"
#include "tandem/model/footprint.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Static obstacles of the plane: the occupied cells (and, on request, the unknown ones) as exact
/// squares, with a Euclidean distance field over them. Immutable, so that threads may share one: by
/// `std::shared_ptr<const StaticMap>` instead of copying it.
class StaticMap {
 public:
  /// Throws std::invalid_argument if the grid's sizes contradict each other. `unknown_is_obstacle`
  /// also applies to everything outside the grid.
  explicit StaticMap(Grid grid, bool unknown_is_obstacle = false);

  /// The grid from which it was made.
  [[nodiscard]] const Grid& grid() const { return grid_; }
  /// Whether cell (ix, iy) counts as an obstacle, which may lie outside the grid.
  [[nodiscard]] bool is_obstacle(int ix, int iy) const;

  /// Lower bound on the distance from a point to the nearest obstacle square [m]. It never exceeds
  /// the true distance and, inside the grid, is at most √2 · resolution below it. 0 on an obstacle
  /// and for a point that is not finite; infinite if there is no obstacle. One look-up.
  [[nodiscard]] double distance(const Eigen::Vector2d& p_MQ) const;

  /// False only if the block of `cells` × `cells` starting at cell (ix, iy) holds no obstacle of
  /// the grid. ix, iy ≥ 0. One look-up; exact for a single cell.
  [[nodiscard]] bool may_hold_obstacle(int ix, int iy, int cells) const;

  /// Exact distance between the footprint at X_MB and the nearest obstacle square [m]: 0 on
  /// contact, at most `cap`. Cost grows with the number of obstacle cells about as near as the
  /// nearest one.
  [[nodiscard]] double clearance(const Footprint& footprint, const Pose2& X_MB, double cap) const;

  /// Lower bound on clearance() [m] by three look-ups per part; lower by at most about a third of
  /// the footprint's narrower side.
  [[nodiscard]] double clearance_bound(const Footprint& footprint, const Pose2& X_MB) const;

  /// Centres of the grid's obstacle cells whose squares come within `radius` [m] of the point.
  [[nodiscard]] std::vector<Eigen::Vector2d> cells_near(const Eigen::Vector2d& p_MQ,
                                                        double radius) const;
  /// As cells_near, plus, if unknown_is_obstacle, the ring of cells around the grid: no obstacle is
  /// nearer than the nearest of them.
  [[nodiscard]] std::vector<Eigen::Vector2d> squares_near(const Eigen::Vector2d& p_MQ,
                                                          double radius) const;

  /// First obstacle along the ray from p_MQ at `heading` in M: distance [m], at most `max_range`.
  [[nodiscard]] double cast_ray(const Eigen::Vector2d& p_MQ, double heading,
                                double max_range) const;

  /// Whether a disc of that radius can move between the two points without contact, its centre
  /// moving from cell to cell of the grid. Conservative: false if in doubt.
  [[nodiscard]] bool can_pass(const Eigen::Vector2d& p_MA, const Eigen::Vector2d& p_MZ,
                              double radius) const;

 private:
  void limit_to_border();
  [[nodiscard]] float field(int ix, int iy) const;
  // Includes `ring` rows and columns beyond each side of the grid.
  [[nodiscard]] std::vector<Eigen::Vector2d> cells_near(const Eigen::Vector2d& p_MQ, double radius,
                                                        int ring) const;
  // One part's clearance [m], at most `cap`. Also returns `cap` if most_clearance() of the pose is
  // less: the part that contains B's origin is then nearer to an obstacle.
  [[nodiscard]] double part_clearance(const ConvexPolygon& part, const Pose2& X_MB,
                                      double cap) const;
  // Upper bound on the clearance of any outline that contains the point [m].
  [[nodiscard]] double most_clearance(const Eigen::Vector2d& p_MB) const;

  Grid grid_;
  bool unknown_is_obstacle_;
  double cells_per_metre_;
  std::vector<float> distance_;  // per cell, centre to nearest obstacle square, rounded down [m]
};

}  // namespace tandem
