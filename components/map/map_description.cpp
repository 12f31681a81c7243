// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/map_description.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "tandem/config/yaml_reader.hpp"
#include "tandem/map/detail/octree_keys.hpp"
#include "tandem/map/detail/voxel_box.hpp"

namespace tandem {
namespace {

constexpr double kMaxVoxels = 5e7;
constexpr double kHuge = YamlReader::kHuge;

// Reads the solid's heights from `height` or `z`.
void read_heights(YamlReader& map, Solid& solid) {
  const auto height = map.optional("height"), z = map.optional("z");
  if (height.has_value() == z.has_value()) map.fail("give one of 'height' and 'z: [low, high]'");
  if (height) {
    solid.z_high = height->number(1e-3, kHuge);
    return;
  }
  const Eigen::Vector2d heights = z->vector<2>();
  if (!(heights[0] < heights[1])) z->fail("z must rise");
  solid.z_low = heights[0];
  solid.z_high = heights[1];
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

void add(const YamlReader& where, const Solid& solid, MapDescription& map) {
  const Eigen::Vector2d half = half_extent(solid);
  const Eigen::Vector3d low{solid.p_MC.x() - half.x(), solid.p_MC.y() - half.y(), solid.z_low};
  const Eigen::Vector3d high{solid.p_MC.x() + half.x(), solid.p_MC.y() + half.y(), solid.z_high};
  if ((low.array() < map.low.array() - 1e-9).any() ||
      (high.array() > map.high.array() + 1e-9).any())
    where.fail("extends beyond the bounds");
  if (solid.size.minCoeff() < map.resolution - 1e-9)
    where.fail("thinner than a voxel: it would have holes");
  if (solid.z_high - solid.z_low < map.resolution - 1e-9)
    where.fail("lower than a voxel: it would not be there");
  map.solids.push_back(solid);
}

void add_wall(YamlReader& wall, MapDescription& map) {
  const YamlReader list = wall.required("points");
  const double thickness = wall.required("thickness").number(1e-3, kHuge);
  const bool closed = wall.optional("closed", false);
  Solid solid;
  read_heights(wall, solid);
  wall.finish();
  const auto points = list.elements();
  if (points.size() < 2) list.fail("expected two or more points");
  const std::size_t count = points.size(), pieces = closed ? count : count - 1;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Eigen::Vector2d from = points[i].vector<2>();
    const Eigen::Vector2d to = points[(i + 1) % count].vector<2>();
    const double length = (to - from).norm();
    if (!(length > 0.0)) points[i].fail("two points of a wall coincide");
    // At a joint the piece extends by half the thickness, so that the corner is filled.
    const double before = closed || i > 0 ? 0.5 * thickness : 0.0;
    const double after = closed || i + 1 < pieces ? 0.5 * thickness : 0.0;
    const Eigen::Vector2d along = (to - from) / length;
    solid.p_MC = 0.5 * (from + to) + 0.5 * (after - before) * along;
    solid.size = {length + before + after, thickness};
    solid.angle = std::atan2(along.y(), along.x());
    add(wall, solid, map);
  }
}

void add_box(YamlReader& box, MapDescription& map) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  Solid solid;
  solid.p_MC = box.required("center").vector<2>();
  solid.size = box.required("size").vector<2>(1e-3, kHuge);
  if (const auto angle = box.optional("angle")) solid.angle = angle->number(-kTurn, kTurn);
  read_heights(box, solid);
  box.finish();
  add(box, solid, map);
}

void add_cylinder(YamlReader& cylinder, MapDescription& map) {
  Solid solid;
  solid.shape = Solid::Shape::kDisc;
  solid.p_MC = cylinder.required("center").vector<2>();
  solid.size.setConstant(cylinder.required("diameter").number(1e-3, kHuge));
  read_heights(cylinder, solid);
  cylinder.finish();
  add(cylinder, solid, map);
}

template <class Add>
void add_all(const std::optional<YamlReader>& list, MapDescription& map, Add add_one) {
  if (!list) return;
  for (YamlReader& value : list->elements()) add_one(value, map);
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

// Voxels along x, y and z.
using Region = std::array<Voxels, 3>;

// Voxels whose centres lie in the solid's bounding box.
Region around(const Solid& solid, double resolution) {
  const Eigen::Vector2d half = half_extent(solid);
  const Eigen::Vector2d low = solid.p_MC - half, high = solid.p_MC + half;
  return {voxels_centered_within(low.x(), high.x(), resolution),
          voxels_centered_within(low.y(), high.y(), resolution),
          voxels_centered_within(solid.z_low, solid.z_high, resolution)};
}

// The voxels that the description makes free or occupied lie within.
Region extent(const MapDescription& description, const Region& bounds) {
  Region extent = bounds;
  if (description.floor) extent[2].begin = std::min(extent[2].begin, -1);
  for (const Solid& solid : description.solids) {
    const Region region = around(solid, description.resolution);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent[axis].begin = std::min(extent[axis].begin, region[axis].begin);
      extent[axis].end = std::max(extent[axis].end, region[axis].end);
    }
  }
  return extent;
}

// Sets voxels by their indices from 0 in M; later states replace earlier ones.
class Painter {
 public:
  explicit Painter(const Region& extent) : voxels_{low_key(extent), size(extent)} {}

  void paint(int ix, int iy, const Voxels& z, bool occupied) {
    voxels_.set_column(ix + kMiddleKey, iy + kMiddleKey, z.begin + kMiddleKey, z.end + kMiddleKey,
                       occupied ? Cube::kOccupied : Cube::kFree);
  }

  [[nodiscard]] std::unique_ptr<octomap::OcTree> tree(double resolution) && {
    return octree_of(std::move(voxels_), resolution);
  }

 private:
  static CubeIndex low_key(const Region& extent) {
    return {extent[0].begin + kMiddleKey, extent[1].begin + kMiddleKey,
            extent[2].begin + kMiddleKey};
  }
  static CubeIndex size(const Region& extent) {
    return {extent[0].end - extent[0].begin, extent[1].end - extent[1].begin,
            extent[2].end - extent[2].begin};
  }

  VoxelBox voxels_;
};

void paint_solid(Painter& painter, const Solid& solid, double resolution) {
  const auto [x, y, z] = around(solid, resolution);
  for (int iy = y.begin; iy < y.end; ++iy)
    for (int ix = x.begin; ix < x.end; ++ix)
      if (contains(solid, {resolution * (ix + 0.5), resolution * (iy + 0.5)}))
        painter.paint(ix, iy, z, true);
}

void read_bounds(YamlReader bounds, MapDescription& map) {
  map.low = bounds.required("low").vector<3>();
  map.high = bounds.required("high").vector<3>();
  bounds.finish();
  if (!(map.low.array() < map.high.array()).all()) bounds.fail("low must be below high");
  const Eigen::Vector3d size = (map.high - map.low) / map.resolution;
  if (size.prod() > kMaxVoxels || size.maxCoeff() > 3e4 ||
      map.low.cwiseAbs().cwiseMax(map.high.cwiseAbs()).maxCoeff() / map.resolution > 3e4)
    bounds.fail("more voxels than a map may have; use a coarser resolution");
}

MapDescription read_map(YamlReader root) {
  MapDescription map;
  map.resolution = root.required("resolution").number(1e-3, 10.0);
  read_bounds(root.required("bounds"), map);
  map.free_space = root.optional("free_space", map.free_space);
  map.floor = root.optional("floor", map.floor);
  const auto walls = root.optional("walls"), boxes = root.optional("boxes"),
             cylinders = root.optional("cylinders");
  root.finish();
  add_all(walls, map, add_wall);
  add_all(boxes, map, add_box);
  add_all(cylinders, map, add_cylinder);
  if (map.solids.empty()) root.fail("nothing solid: give walls, boxes or cylinders");
  return map;
}

}  // namespace

MapDescription parse_map_description(const std::string& text, const std::string& name) {
  return read_map(YamlReader::parse(text, name));
}

MapDescription load_map_description(const std::filesystem::path& file) {
  return read_map(YamlReader::load(file.string()));
}

std::unique_ptr<octomap::OcTree> build_octomap(const MapDescription& description) {
  const auto along = [&](int axis) {
    return voxels_within(description.low[axis], description.high[axis], description.resolution);
  };
  const Region bounds{along(0), along(1), along(2)};
  const auto& [x, y, z] = bounds;
  Painter painter{extent(description, bounds)};
  for (int ix = x.begin; ix < x.end; ++ix)
    for (int iy = y.begin; iy < y.end; ++iy) {
      if (description.free_space) painter.paint(ix, iy, z, false);
      if (description.floor) painter.paint(ix, iy, {-1, 0}, true);
    }
  for (const Solid& solid : description.solids) paint_solid(painter, solid, description.resolution);
  return std::move(painter).tree(description.resolution);
}

}  // namespace tandem
