// SPDX-License-Identifier: Apache-2.0
// Loads the worlds that the extractor's tests and benchmark use.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "tandem/map/barn_world.hpp"
#include "tandem/map/octomap_file.hpp"
#include "tandem/map/slice.hpp"
#include "tandem/map/static_map.hpp"
#include "tandem/model/obstacle.hpp"

namespace tandem::test {

inline std::filesystem::path project_map(const std::string& name) {
  return source_path("maps/" + name + ".bt");
}

/// The real building; may be missing.
inline std::filesystem::path building_map() { return shared_path("maps/geb079.bt"); }

/// The BARN worlds; may be missing.
inline std::filesystem::path barn_file() { return shared_path("barn/worlds.json"); }

inline std::shared_ptr<const StaticMap> barn_world(int number) {
  const auto tree = build_octomap(load_barn_world(barn_file(), number));
  return std::make_shared<StaticMap>(slice(*tree, {.z_min = 0.10, .z_max = 1.0}));
}

inline std::shared_ptr<const StaticMap> load_world(const std::filesystem::path& file) {
  return std::make_shared<StaticMap>(slice(*load_octomap(file), {.z_min = 0.10, .z_max = 1.0}));
}

/// 6 m × 5 m with walls, poles, blocks, noise and unknown patches at random positions.
inline std::shared_ptr<const StaticMap> random_world(unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Grid grid;
  grid.resolution = 0.04 + 0.06 * unit(random);
  grid.origin = {10.0 * unit(random) - 5.0, 10.0 * unit(random) - 5.0};
  grid.width = static_cast<int>(6.0 / grid.resolution);
  grid.height = static_cast<int>(5.0 / grid.resolution);
  grid.cells.assign(static_cast<std::size_t>(grid.width * grid.height), Cell::kFree);
  const int solids = static_cast<int>(12.0 * unit(random));
  for (int i = 0; i < solids; ++i) {
    const Eigen::Vector2d p_MC =
        grid.origin + Eigen::Vector2d{6.0 * unit(random), 5.0 * unit(random)};
    const double length = 0.1 + 2.5 * unit(random), width = 0.06 + 0.5 * std::pow(unit(random), 3);
    const double angle = 3.2 * unit(random), kind = unit(random);
    const Cell cell = unit(random) < 0.8 ? Cell::kOccupied : Cell::kUnknown;
    for (int iy = 0; iy < grid.height; ++iy)
      for (int ix = 0; ix < grid.width; ++ix) {
        const Eigen::Vector2d d = grid.center(ix, iy) - p_MC;
        const double x = std::cos(angle) * d.x() + std::sin(angle) * d.y();
        const double y = -std::sin(angle) * d.x() + std::cos(angle) * d.y();
        const bool inside =
            kind < 0.3 ? d.norm() < width : std::abs(x) < 0.5 * length && std::abs(y) < 0.5 * width;
        if (inside) grid.cells[static_cast<std::size_t>(iy * grid.width + ix)] = cell;
      }
  }
  for (auto& cell : grid.cells)
    if (unit(random) < 0.002) cell = Cell::kOccupied;
  return std::make_shared<StaticMap>(std::move(grid), seed % 3 == 0);
}

inline bool lies_in_one_shape(const Eigen::Vector2d& p_MC, double side,
                              const std::vector<Obstacle>& shapes) {
  return std::any_of(shapes.begin(), shapes.end(), [&](const Obstacle& shape) {
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        if (!contains(shape, p_MC + side * Eigen::Vector2d{x, y})) return false;
    return true;
  });
}

/// Obstacle cells within `range` of the point that are not entirely inside one shape.
inline int uncovered_cells(const StaticMap& map, const Eigen::Vector2d& p_MB, double range,
                           const std::vector<Obstacle>& shapes) {
  int count = 0;
  for (const auto& p_MC : map.cells_near(p_MB, range))
    if (!lies_in_one_shape(p_MC, map.grid().resolution, shapes)) ++count;
  return count;
}

inline Eigen::Vector2d random_point(std::mt19937& random, const Grid& grid) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  return grid.origin +
         grid.resolution * Eigen::Vector2d{grid.width * unit(random), grid.height * unit(random)};
}

/// True if both lists hold exactly the same shapes in the same order.
inline void expect_same(const std::vector<Obstacle>& a, const std::vector<Obstacle>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].p_MO, b[i].p_MO);
    EXPECT_EQ(a[i].a, b[i].a);
    EXPECT_EQ(a[i].b, b[i].b);
    EXPECT_EQ(a[i].angle, b[i].angle);
  }
}

}  // namespace tandem::test
