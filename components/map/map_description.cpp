// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/map_description.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "tandem/config/yaml_reader.hpp"

namespace tandem {
namespace {

constexpr double kMaxVoxels = 5e7;
constexpr double kHuge = YamlReader::kHuge;

// Reads the solid's heights from `height` or `z`.
void read_heights(const YamlReader& reader, const YAML::Node& map, Solid& solid) {
  if (static_cast<bool>(map["height"]) == static_cast<bool>(map["z"]))
    reader.fail(map, "give exactly one of 'height' and 'z: [low, high]'");
  if (map["height"]) {
    solid.z_high = reader.number(map["height"], 1e-3, kHuge);
    return;
  }
  const Eigen::Vector2d z = reader.vector<2>(map["z"]);
  if (!(z[0] < z[1])) reader.fail(map["z"], "z must be [low, high] with low < high");
  solid.z_low = z[0];
  solid.z_high = z[1];
}

// Half extents of the solid's bounding box in the plane.
Eigen::Vector2d half_extent(const Solid& solid) {
  if (solid.shape == Solid::Shape::kDisc) return 0.5 * solid.size;
  const double c = std::abs(std::cos(solid.angle)), s = std::abs(std::sin(solid.angle));
  return 0.5 * Eigen::Vector2d{c * solid.size.x() + s * solid.size.y(),
                               s * solid.size.x() + c * solid.size.y()};
}

bool contains(const Solid& solid, const Eigen::Vector2d& p_MQ) {
  constexpr double kRounding = 1e-9;  // [m] so that a centre on the edge counts on every side
  const Eigen::Vector2d d = p_MQ - solid.p_MC;
  if (solid.shape == Solid::Shape::kDisc) return d.norm() <= 0.5 * solid.size.x() + kRounding;
  const double c = std::cos(solid.angle), s = std::sin(solid.angle);
  return std::abs(c * d.x() + s * d.y()) <= 0.5 * solid.size.x() + kRounding &&
         std::abs(-s * d.x() + c * d.y()) <= 0.5 * solid.size.y() + kRounding;
}

void add(const YamlReader& reader, const YAML::Node& where, const Solid& solid,
         MapDescription& map) {
  const Eigen::Vector2d half = half_extent(solid);
  const Eigen::Vector3d low{solid.p_MC.x() - half.x(), solid.p_MC.y() - half.y(), solid.z_low};
  const Eigen::Vector3d high{solid.p_MC.x() + half.x(), solid.p_MC.y() + half.y(), solid.z_high};
  if ((low.array() < map.low.array() - 1e-9).any() ||
      (high.array() > map.high.array() + 1e-9).any())
    reader.fail(where, "extends beyond the bounds");
  if (solid.size.minCoeff() < map.resolution - 1e-9)
    reader.fail(where, "thinner than a voxel: it would have gaps");
  if (solid.z_high - solid.z_low < map.resolution - 1e-9)
    reader.fail(where, "lower than a voxel: it would disappear");
  map.solids.push_back(solid);
}

void add_wall(const YamlReader& reader, const YAML::Node& node, MapDescription& map) {
  reader.allow(node, {"points", "thickness", "height", "z", "closed"});
  const YAML::Node points = reader.required(node, "points");
  const double thickness = reader.number(reader.required(node, "thickness"), 1e-3, kHuge);
  const bool closed = reader.flag(node, "closed", false);
  if (!points.IsSequence() || points.size() < 2)
    reader.fail(points, "expected at least two points");
  const std::size_t count = points.size(), pieces = closed ? count : count - 1;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Eigen::Vector2d from = reader.vector<2>(points[i]);
    const Eigen::Vector2d to = reader.vector<2>(points[(i + 1) % count]);
    const double length = (to - from).norm();
    if (!(length > 0.0)) reader.fail(points[i], "two consecutive points of a wall coincide");
    // At a joint the piece extends by half the thickness, so that the corner is filled.
    const double before = closed || i > 0 ? 0.5 * thickness : 0.0;
    const double after = closed || i + 1 < pieces ? 0.5 * thickness : 0.0;
    const Eigen::Vector2d along = (to - from) / length;
    Solid solid;
    solid.p_MC = 0.5 * (from + to) + 0.5 * (after - before) * along;
    solid.size = {length + before + after, thickness};
    solid.angle = std::atan2(along.y(), along.x());
    read_heights(reader, node, solid);
    add(reader, node, solid, map);
  }
}

void add_box(const YamlReader& reader, const YAML::Node& node, MapDescription& map) {
  reader.allow(node, {"center", "size", "angle", "height", "z"});
  Solid solid;
  solid.p_MC = reader.vector<2>(reader.required(node, "center"));
  solid.size = reader.vector<2>(reader.required(node, "size"), 1e-3, kHuge);
  if (node["angle"])
    solid.angle = reader.number(node["angle"], -2.0 * std::numbers::pi, 2.0 * std::numbers::pi);
  read_heights(reader, node, solid);
  add(reader, node, solid, map);
}

void add_cylinder(const YamlReader& reader, const YAML::Node& node, MapDescription& map) {
  reader.allow(node, {"center", "diameter", "height", "z"});
  Solid solid;
  solid.shape = Solid::Shape::kDisc;
  solid.p_MC = reader.vector<2>(reader.required(node, "center"));
  solid.size.setConstant(reader.number(reader.required(node, "diameter"), 1e-3, kHuge));
  read_heights(reader, node, solid);
  add(reader, node, solid, map);
}

template <class Add>
void add_all(const YamlReader& reader, const YAML::Node& list, MapDescription& map, Add add_one) {
  if (!list) return;
  if (!list.IsSequence()) reader.fail(list, "expected a list");
  for (const auto& node : list) add_one(reader, node, map);
}

// Voxels [begin, end) along one axis, counted from 0 in M.
struct Voxels {
  int begin, end;
};

Voxels voxels_within(double low, double high, double resolution) {
  return {static_cast<int>(std::floor(low / resolution + 1e-6)),
          static_cast<int>(std::ceil(high / resolution - 1e-6))};
}

// Voxels whose centres lie within [low, high], edges included.
Voxels voxels_centered_within(double low, double high, double resolution) {
  return {static_cast<int>(std::ceil(low / resolution - 0.5 - 1e-6)),
          static_cast<int>(std::floor(high / resolution - 0.5 + 1e-6)) + 1};
}

// Writes one state into many voxels of a tree; later states replace earlier ones.
class Painter {
 public:
  explicit Painter(octomap::OcTree& tree) : tree_{tree} {}

  void paint(int ix, int iy, const Voxels& z, bool occupied) {
    const float log_odds =
        occupied ? tree_.getClampingThresMaxLog() : tree_.getClampingThresMinLog();
    for (int iz = z.begin; iz < z.end; ++iz)
      tree_.setNodeValue(octomap::OcTreeKey(key(ix), key(iy), key(iz)), log_odds, true);
  }

 private:
  [[nodiscard]] static octomap::key_type key(int i) {
    return static_cast<octomap::key_type>(i + 32768);
  }

  octomap::OcTree& tree_;
};

void paint_solid(Painter& painter, const Solid& solid, double resolution) {
  const Eigen::Vector2d half = half_extent(solid);
  const Eigen::Vector2d low = solid.p_MC - half, high = solid.p_MC + half;
  const Voxels x = voxels_centered_within(low.x(), high.x(), resolution);
  const Voxels y = voxels_centered_within(low.y(), high.y(), resolution);
  const Voxels z = voxels_centered_within(solid.z_low, solid.z_high, resolution);
  for (int iy = y.begin; iy < y.end; ++iy)
    for (int ix = x.begin; ix < x.end; ++ix)
      if (contains(solid, {resolution * (ix + 0.5), resolution * (iy + 0.5)}))
        painter.paint(ix, iy, z, true);
}

MapDescription read_map(const YamlReader& reader, const YAML::Node& root) {
  reader.allow(root,
               {"resolution", "bounds", "free_space", "floor", "walls", "boxes", "cylinders"});
  MapDescription map;
  map.resolution = reader.number(reader.required(root, "resolution"), 1e-3, 10.0);
  const YAML::Node bounds = reader.required(root, "bounds");
  reader.allow(bounds, {"low", "high"});
  map.low = reader.vector<3>(reader.required(bounds, "low"));
  map.high = reader.vector<3>(reader.required(bounds, "high"));
  if (!(map.low.array() < map.high.array()).all()) reader.fail(bounds, "low must be below high");
  const Eigen::Vector3d size = (map.high - map.low) / map.resolution;
  if (size.prod() > kMaxVoxels || size.maxCoeff() > 3e4 ||
      map.low.cwiseAbs().cwiseMax(map.high.cwiseAbs()).maxCoeff() / map.resolution > 3e4)
    reader.fail(bounds, "too many voxels for a map; use a coarser resolution");
  map.free_space = reader.flag(root, "free_space", map.free_space);
  map.floor = reader.flag(root, "floor", map.floor);
  add_all(reader, root["walls"], map, add_wall);
  add_all(reader, root["boxes"], map, add_box);
  add_all(reader, root["cylinders"], map, add_cylinder);
  if (map.solids.empty()) reader.fail(root, "the map is empty: add walls, boxes or cylinders");
  return map;
}

}  // namespace

MapDescription parse_map_description(const std::string& text, const std::string& name) {
  const YamlReader reader{name};
  return read_map(reader, reader.parse(text));
}

MapDescription load_map_description(const std::filesystem::path& file) {
  const YamlReader reader{file.string()};
  return read_map(reader, reader.load());
}

std::unique_ptr<octomap::OcTree> build_octomap(const MapDescription& description) {
  auto tree = std::make_unique<octomap::OcTree>(description.resolution);
  Painter painter(*tree);
  const auto along = [&](int axis) {
    return voxels_within(description.low[axis], description.high[axis], description.resolution);
  };
  const Voxels x = along(0), y = along(1), z = along(2);
  for (int iy = y.begin; iy < y.end; ++iy)
    for (int ix = x.begin; ix < x.end; ++ix) {
      if (description.free_space) painter.paint(ix, iy, z, false);
      if (description.floor) painter.paint(ix, iy, {-1, 0}, true);
    }
  for (const Solid& solid : description.solids) paint_solid(painter, solid, description.resolution);
  tree->updateInnerOccupancy();
  tree->prune();
  return tree;
}

}  // namespace tandem
