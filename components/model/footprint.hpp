// SPDX-License-Identifier: Apache-2.0
// The robot's outline in its own frame B, exact distances to it, and discs that cover it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tandem/model/obstacle.hpp"
#include "tandem/model/se2.hpp"

namespace tandem {

/// Vertices p_BV of a convex polygon, counter-clockwise [m].
using ConvexPolygon = std::vector<Eigen::Vector2d>;

/// The robot's outline in body frame B: the union of convex parts, which may overlap or lie apart.
/// Build it with rectangle(), polygons() or polygon().
struct Footprint {
  std::vector<ConvexPolygon> parts;  ///< at least one
};

/// Disc that covers a part of the footprint: centre in B [m] and radius [m].
struct Disc {
  Eigen::Vector2d p_BC;  ///< centre [m]
  double radius;         ///< [m]
};

/// Rectangle `length` × `width` whose centre lies at (center_x, 0) in B.
[[nodiscard]] Footprint rectangle(double length, double width, double center_x);

/// A footprint of the given parts. Throws std::invalid_argument unless each part is a convex,
/// counter-clockwise polygon that does not cross itself, and at least one part contains B's origin;
/// the message names part and vertex, both counted from 1.
[[nodiscard]] Footprint polygons(std::vector<ConvexPolygon> parts);

/// polygons() for a single part.
[[nodiscard]] Footprint polygon(ConvexPolygon p_BV);

/// Radius of the smallest disc about B's origin that contains the footprint [m].
[[nodiscard]] double circumradius(const Footprint& footprint);

/// Distances from B's origin to the footprint's extremes along B's axes [m].
struct Extent {
  double front = 0.0, rear = 0.0, left = 0.0, right = 0.0;  ///< [m], below 0 beyond the origin
};
/// The footprint's extremes along B's axes [m].
[[nodiscard]] Extent extent(const Footprint& footprint);

/// Extent of the footprint across B's x axis, the direction of travel [m].
[[nodiscard]] double width(const Footprint& footprint);

/// Distance from the footprint, or from one part, to a point in B [m], 0 inside.
[[nodiscard]] double distance(const Footprint& footprint, const Eigen::Vector2d& p_BQ);
[[nodiscard]] double distance(const ConvexPolygon& part, const Eigen::Vector2d& p_BQ);

/// Distance from the footprint, or from one part, at X_MB to the axis-parallel square of side
/// `side` around `p_MC` [m], 0 if they touch. Exact.
[[nodiscard]] double distance_to_square(const Footprint& footprint, const Pose2& X_MB,
                                        const Eigen::Vector2d& p_MC, double side);
[[nodiscard]] double distance_to_square(const ConvexPolygon& part, const Pose2& X_MB,
                                        const Eigen::Vector2d& p_MC, double side);

/// The footprint with every edge of every part moved inwards by `depth` ≥ 0 [m]. Parts that vanish
/// are dropped, and B's origin may end up outside the result.
[[nodiscard]] Footprint inset(const Footprint& footprint, double depth);

/// Whether the footprint at X_MB overlaps the obstacle. Exact: for an ellipse, the affine map that
/// turns it into a unit disc keeps each part a convex polygon; for a rectangle, two convex polygons
/// are apart if and only if a line along a side of one of them separates them.
[[nodiscard]] bool overlaps(const Footprint& footprint, const Pose2& X_MB,
                            const Obstacle& obstacle);

/// Discs that cover the footprint. The bounding box is cut along x into the fewest equal slices
/// whose discs, each the smallest around its slice, extend at most `overhang` > 0 [m] beyond the
/// box's sides. Beyond the ends they extend as far as a disc as wide as the robot does. With
/// several parts each is covered separately, sliced along the longer side of its box: a single disc
/// across a wide part would fill the space between the forks that the part joins.
[[nodiscard]] std::vector<Disc> cover_by_discs(const Footprint& footprint, double overhang);

}  // namespace tandem
