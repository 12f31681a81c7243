// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/virtual_fixtures.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "tandem/config/yaml_reader.hpp"

namespace tandem {
namespace {

using Eigen::Vector2d;

struct RegionBox {
  Vector2d low, high;
};

RegionBox box_of(const ForbiddenRegion& region) {
  RegionBox box{region.p_MV.front(), region.p_MV.front()};
  for (const Vector2d& p : region.p_MV) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

double distance_to_edge(const Vector2d& p, const Vector2d& from, const Vector2d& to) {
  const Vector2d edge = to - from;
  const double length2 = edge.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp((p - from).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return (p - from - s * edge).norm();
}

// Whether p is inside (by crossings of a ray along x) or at most `slack` from an edge.
bool reaches(const ForbiddenRegion& region, const Vector2d& p, double slack) {
  bool inside = false;
  for (std::size_t i = 0; i < region.p_MV.size(); ++i) {
    const Vector2d& a = region.p_MV[i];
    const Vector2d& b = region.p_MV[(i + 1) % region.p_MV.size()];
    if (distance_to_edge(p, a, b) <= slack) return true;
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

// The grid extended to contain the box.
Grid grown(const Grid& grid, const RegionBox& box) {
  const double r = grid.resolution;
  const Vector2d below = ((grid.origin - box.low) / r).array().ceil().max(0.0);
  const Vector2d size{grid.width, grid.height};
  const Vector2d above = (((box.high - grid.origin) / r) - size).array().ceil().max(0.0);
  if (below.isZero() && above.isZero()) return grid;
  const Vector2d total = below + size + above;
  if (!(total.prod() <= static_cast<double>(kMaxCells)))
    throw std::runtime_error(
        "a forbidden region is so far from the map that the grid would exceed 10⁸ cells");
  const Eigen::Vector2i shift = below.cast<int>();
  Grid out{
      r, grid.origin - r * below, static_cast<int>(total.x()), static_cast<int>(total.y()), {}};
  out.cells.assign(static_cast<std::size_t>(total.prod()), Cell::kUnknown);
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix)
      out.cells[out.index(ix + shift.x(), iy + shift.y())] = grid.at(ix, iy);
  return out;
}

void occupy(Grid& grid, const ForbiddenRegion& region) {
  const double r = grid.resolution, slack = std::sqrt(0.5) * r;
  const RegionBox box = box_of(region);
  const Vector2d low = (box.low - grid.origin) / r, high = (box.high - grid.origin) / r;
  const int x1 = std::min(grid.width - 1, static_cast<int>(high.x()) + 1);
  const int y1 = std::min(grid.height - 1, static_cast<int>(high.y()) + 1);
  for (int iy = std::max(0, static_cast<int>(low.y()) - 1); iy <= y1; ++iy)
    for (int ix = std::max(0, static_cast<int>(low.x()) - 1); ix <= x1; ++ix)
      if (reaches(region, grid.center(ix, iy), slack))
        grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
}

std::vector<Vector2d> read_points(const YamlReader& list, std::size_t least) {
  const auto values = list.is_list() ? list.elements() : std::vector<YamlReader>{};
  if (values.size() < least)
    list.fail("expected " + std::string{least == 2 ? "two" : "three"} +
              " or more points, [[x, y], …]");
  std::vector<Vector2d> points;
  for (const YamlReader& point : values) points.push_back(point.vector<2>());
  return points;
}

ForbiddenRegion read_region(YamlReader& map) {
  ForbiddenRegion region{map.optional<std::string>("name", ""),
                         read_points(map.required("polygon"), 3)};
  map.finish();
  return region;
}

GuidanceLine read_line(YamlReader& map) {
  GuidanceLine line{map.optional<std::string>("name", ""), read_points(map.required("line"), 2)};
  if (const auto reach = map.optional("reach")) line.reach = reach->number(0.05, 10.0);
  if (const auto strength = map.optional("strength")) line.strength = strength->number(0.0, 1.0);
  map.finish();
  return line;
}

// The elements of a list; none without it.
template <class Read>
auto read_list(const std::optional<YamlReader>& list, Read read) {
  std::vector<decltype(read(std::declval<YamlReader&>()))> all;
  if (!list) return all;
  for (YamlReader& value : list->elements()) all.push_back(read(value));
  return all;
}

}  // namespace

VirtualFixtures load_virtual_fixtures(const std::filesystem::path& file) {
  YamlReader root = YamlReader::load(file.string());
  const auto forbidden = root.optional("forbidden"), guidance = root.optional("guidance");
  root.finish();
  return {read_list(forbidden, read_region), read_list(guidance, read_line)};
}

Grid with_forbidden(Grid grid, const VirtualFixtures& fixtures) {
  for (const ForbiddenRegion& region : fixtures.forbidden) {
    grid = grown(grid, box_of(region));
    occupy(grid, region);
  }
  return grid;
}

}  // namespace tandem
