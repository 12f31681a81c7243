// SPDX-License-Identifier: Apache-2.0
// In: the robot's outline in its own frame B. Out: exact distances to it, discs that cover it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/obstacle.hpp"
#include "model/se2.hpp"

namespace tandem {

/// Convex outline of the robot in body frame B, counter-clockwise vertices [m].
struct Footprint {
  std::vector<Eigen::Vector2d> p_BV;
};

/// Disc that covers a part of the footprint: centre on B's x axis or anywhere in B [m].
struct Disc {
  Eigen::Vector2d p_BC;
  double radius;
};

/// Rectangle `length` × `width` whose centre lies at (center_x, 0) in B.
[[nodiscard]] Footprint rectangle(double length, double width, double center_x);

/// Checks that the vertices form a convex, counter-clockwise polygon that contains B's origin.
/// Throws std::invalid_argument otherwise.
[[nodiscard]] Footprint polygon(std::vector<Eigen::Vector2d> p_BV);

/// Radius of the smallest disc about B's origin that contains the footprint [m].
[[nodiscard]] double circumradius(const Footprint& footprint);

/// Distance from the footprint to a point in B [m], 0 inside.
[[nodiscard]] double distance(const Footprint& footprint, const Eigen::Vector2d& p_BQ);

/// Distance from the footprint at X_MB to the axis-parallel square of side `side` around
/// `p_MC` [m], 0 if they touch. Exact.
[[nodiscard]] double distance_to_square(const Footprint& footprint, const Pose2& X_MB,
                                        const Eigen::Vector2d& p_MC, double side);

/// Whether the footprint at X_MB overlaps the ellipse grown by nothing. Exact: the affine map that
/// makes the ellipse a unit disc keeps the outline a polygon.
[[nodiscard]] bool overlaps(const Footprint& footprint, const Pose2& X_MB,
                            const Obstacle& obstacle);

/// The fewest equal slices along x whose discs, each the smallest about its slice's centre, reach
/// at most `overhang` > 0 [m] beyond the bounding box's sides; their union contains the footprint.
/// Beyond the ends they reach as far as a disc as wide as the robot does.
[[nodiscard]] std::vector<Disc> cover_by_discs(const Footprint& footprint, double overhang);

}  // namespace tandem
