// SPDX-License-Identifier: Apache-2.0
#include "bringup/urdf/collision_outline.hpp"

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bringup/urdf/stl_file.hpp"
#include "tandem/model/convex_hull.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

using Points3 = std::vector<Eigen::Vector3d>;  // [m]

Points3 corners_of(const Eigen::AlignedBox3d& box) {
  Points3 corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  return corners;
}

// A regular polygon around the circle in the plane z; the middles of four sides touch the axes.
void add_circle(double radius, double z, Points3& points) {
  constexpr int kSides = 24;
  const double half_side = std::numbers::pi / kSides;  // as an angle [rad]
  for (int i = 0; i < kSides; ++i) {
    const double angle = (2 * i + 1) * half_side, distance = radius / std::cos(half_side);
    points.emplace_back(distance * std::cos(angle), distance * std::sin(angle), z);
  }
}

// A link's mesh. Its file is looked for as ROS 2 does, and, for a URDF that is not installed, in
// the folder of its package.
class MeshFile {
 public:
  MeshFile(const std::string& uri, const fs::path& urdf) : uri_{uri}, urdf_{fs::absolute(urdf)} {}

  [[nodiscard]] fs::path path() const {
    if (uri_.starts_with("package://")) return in_package(uri_.substr(10));
    if (uri_.starts_with("file://")) return uri_.substr(7);
    if (uri_.find("://") != std::string::npos)
      throw std::runtime_error("only package:// and file:// are supported");
    return urdf_.parent_path() / uri_;
  }

 private:
  [[nodiscard]] fs::path in_package(const fs::path& name_and_file) const {
    const fs::path name = *name_and_file.begin(), file = name_and_file.lexically_relative(name);
    for (fs::path folder = urdf_.parent_path(); folder.has_relative_path();
         folder = folder.parent_path())
      if (folder.filename() == name && fs::exists(folder / file)) return folder / file;
    const char* const prefixes = std::getenv("AMENT_PREFIX_PATH");
    std::istringstream list{prefixes == nullptr ? "" : prefixes};
    for (std::string prefix; std::getline(list, prefix, ':');)
      if (const fs::path found = fs::path{prefix} / "share" / name / file; fs::exists(found))
        return found;
    throw std::runtime_error("neither above the URDF nor in AMENT_PREFIX_PATH; is package '" +
                             name.string() + "' installed, and its workspace sourced?");
  }

  std::string uri_;
  fs::path urdf_;
};

Points3 points_of(const urdf::Mesh& mesh, const fs::path& urdf) {
  const fs::path file = MeshFile{mesh.filename, urdf}.path();
  const std::string extension = file.extension().string();
  if (extension != ".stl" && extension != ".STL")
    throw std::runtime_error(
        "only STL meshes can be read; in a copy of the URDF, replace it by a box around it");
  const Eigen::Vector3d scale{mesh.scale.x, mesh.scale.y, mesh.scale.z};
  Points3 corners = corners_of(stl_bounding_box(file));
  for (Eigen::Vector3d& corner : corners) corner = corner.cwiseProduct(scale);
  return corners;
}

Points3 points_of(const urdf::Box& box) {
  const Eigen::Vector3d half = 0.5 * Eigen::Vector3d{box.dim.x, box.dim.y, box.dim.z};
  return corners_of(Eigen::AlignedBox3d{-half, half});
}

Points3 points_of(const urdf::Cylinder& cylinder) {
  Points3 points;
  for (const double z : {-0.5 * cylinder.length, 0.5 * cylinder.length})
    add_circle(cylinder.radius, z, points);
  return points;
}

// Added to the outline. Spheres are projected here, because their outline does not turn.
void add(const urdf::Geometry& geometry, const Eigen::Isometry3d& X_BG, const fs::path& urdf,
         ConvexPolygon& outline) {
  Points3 points;  // in G
  if (geometry.type == urdf::Geometry::SPHERE) {
    add_circle(static_cast<const urdf::Sphere&>(geometry).radius, 0.0, points);
    for (const Eigen::Vector3d& p : points)
      outline.emplace_back((X_BG.translation() + p).head<2>());
    return;
  }
  if (geometry.type == urdf::Geometry::BOX)
    points = points_of(static_cast<const urdf::Box&>(geometry));
  else if (geometry.type == urdf::Geometry::CYLINDER)
    points = points_of(static_cast<const urdf::Cylinder&>(geometry));
  else
    points = points_of(static_cast<const urdf::Mesh&>(geometry), urdf);
  for (const Eigen::Vector3d& p_GP : points) outline.emplace_back((X_BG * p_GP).head<2>());
}

std::string name_of(const urdf::Geometry& geometry) {
  return geometry.type == urdf::Geometry::MESH
             ? "mesh " + static_cast<const urdf::Mesh&>(geometry).filename
             : "its collision geometry";
}

}  // namespace

ConvexPolygon collision_outline(const UrdfModel& model, const Eigen::Isometry3d& X_RB) {
  ConvexPolygon points;
  for (const auto& [name, placed] : model.links())
    for (const auto& collision : placed.link->collision_array) try {
        add(*collision->geometry, X_RB.inverse() * placed.X_RL * to_isometry(collision->origin),
            model.file(), points);
      } catch (const std::exception& error) {
        model.fail("link '" + name + "': " + name_of(*collision->geometry) + ": " + error.what());
      }
  if (points.empty()) model.fail("no link has a collision geometry; the outline is made of it");
  constexpr double kPerMetre = 1e4;
  for (Eigen::Vector2d& p : points) p = (kPerMetre * p).array().round() / kPerMetre;
  ConvexPolygon hull = convex_hull(std::move(points));
  if (hull.size() < 3) model.fail("the collision geometry has no area, seen from above");
  return hull;
}

}  // namespace tandem
