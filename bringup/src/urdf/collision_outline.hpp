// SPDX-License-Identifier: Apache-2.0
// The outline of a URDF's collision geometry, seen from above.
#pragma once

#include <Eigen/Geometry>

#include "bringup/urdf/urdf_model.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {

/// Convex hull of the collision geometry of all links in the plane z = 0 of frame B, whose pose in
/// the root link is X_RB, at position 0 of all joints; coordinates are rounded to 0.1 mm. Circles
/// become polygons of 24 sides around them, which reach out by up to 0.9 % of the radius; of a mesh
/// (STL) the box around it counts. Throws like UrdfModel::fail(), naming the link, if a mesh cannot
/// be found or read, and if there is no collision geometry with an area.
[[nodiscard]] ConvexPolygon collision_outline(const UrdfModel& model,
                                              const Eigen::Isometry3d& X_RB);

}  // namespace tandem
