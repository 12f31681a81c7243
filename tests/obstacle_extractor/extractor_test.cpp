// SPDX-License-Identifier: Apache-2.0
#include "obstacle_extractor/extractor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <random>
#include <set>

#include "worlds.hpp"

namespace tandem {
namespace {

using test::building_map;
using test::load_world;
using test::project_map;
using test::random_point;
using test::random_world;

bool lies_in_one_shape(const Eigen::Vector2d& p_MC, double side,
                       const std::vector<Obstacle>& shapes) {
  return std::any_of(shapes.begin(), shapes.end(), [&](const Obstacle& shape) {
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        if (level(shape, p_MC + side * Eigen::Vector2d{x, y}) > 1.0 + 1e-12) return false;
    return true;
  });
}

int uncovered_cells(const StaticMap& map, const Eigen::Vector2d& p_MB, double range,
                    const std::vector<Obstacle>& shapes) {
  int count = 0;
  for (const auto& p_MC : map.cells_near(p_MB, range))
    if (!lies_in_one_shape(p_MC, map.grid().resolution, shapes)) ++count;
  return count;
}

void expect_covered(const std::shared_ptr<const StaticMap>& map, int poses) {
  const ExtractorParams params;
  Extractor extractor(map, params);
  std::mt19937 random{7};
  for (int i = 0; i < poses; ++i) {
    const Eigen::Vector2d p_MB = random_point(random, map->grid());
    ASSERT_EQ(uncovered_cells(*map, p_MB, params.range, extractor.near(p_MB)), 0)
        << "at " << p_MB.transpose();
  }
}

struct Tightness {
  int free_poses = 0, lost_poses = 0;
  double mean_shapes = 0.0, most_shapes = 0.0;

  [[nodiscard]] double lost() const { return 1.0 * lost_poses / free_poses; }
};

// Of the poses within 2 m of the robot that are free by the map's cells, with the whole footprint's
// surroundings known, how many touch a shape? The robot itself stands somewhere it can.
Tightness measure(const std::shared_ptr<const StaticMap>& map, const Footprint& footprint,
                  const ExtractorParams& params) {
  Extractor extractor(map, params);
  std::mt19937 random{11};
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Grid& grid = map->grid();
  const auto is_free = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d c = (p - grid.origin) / grid.resolution;
    const int ix = static_cast<int>(std::floor(c.x())), iy = static_cast<int>(std::floor(c.y()));
    return grid.contains(ix, iy) && grid.at(ix, iy) == Cell::kFree;
  };
  Tightness result;
  int places = 0;
  while (places < 150) {
    const Eigen::Vector2d p_MB = random_point(random, grid);
    if (!is_free(p_MB) ||
        map->clearance(footprint, {p_MB.x(), p_MB.y(), 7.0 * unit(random)}, 1.0) == 0.0)
      continue;
    ++places;
    const auto shapes = extractor.near(p_MB);
    result.mean_shapes += static_cast<double>(shapes.size()) / 150.0;
    result.most_shapes = std::max(result.most_shapes, static_cast<double>(shapes.size()));
    for (int i = 0; i < 40; ++i) {
      const Pose2 X_MB{p_MB.x() + 4.0 * unit(random) - 2.0, p_MB.y() + 4.0 * unit(random) - 2.0,
                       7.0 * unit(random)};
      const auto& outline = footprint.p_BV;
      if (!is_free(X_MB.position()) || map->clearance(footprint, X_MB, 0.01) == 0.0 ||
          !std::all_of(outline.begin(), outline.end(),
                       [&](const auto& p_BV) { return is_free(transform(X_MB, p_BV)); }))
        continue;
      ++result.free_poses;
      if (std::any_of(shapes.begin(), shapes.end(),
                      [&](const auto& shape) { return overlaps(footprint, X_MB, shape); }))
        ++result.lost_poses;
    }
  }
  return result;
}

void expect_tight(const char* name, const std::shared_ptr<const StaticMap>& map,
                  const Footprint& footprint, double most_lost) {
  const Tightness tightness = measure(map, footprint, {});
  std::printf("%-12s %5d free poses, %4.1f %% lost; shapes within 4 m: mean %.1f, most %.0f\n",
              name, tightness.free_poses, 100.0 * tightness.lost(), tightness.mean_shapes,
              tightness.most_shapes);
  EXPECT_GT(tightness.free_poses, 500);
  EXPECT_LE(tightness.lost(), most_lost);
}

// Depth in free space of the deepest point of any shape on the map, the depth by the whole map.
// Shapes around a single cell are left out: they are as large as the cell makes them.
double deepest_point(const std::shared_ptr<const StaticMap>& map, const ExtractorParams& params) {
  const Grid& grid = map->grid();
  const bool all_unknown =
      std::find(grid.cells.begin(), grid.cells.end(), Cell::kFree) == grid.cells.end();
  const FreeDepth depth(*map, {-50, -50, grid.width + 50, grid.height + 50},
                        {.smallest_gap = params.smallest_gap, .unknown_is_free = all_unknown});
  const double size = grid.resolution * (grid.width + grid.height);
  ExtractorParams everywhere = params;
  everywhere.range = 50.0;
  double deepest = 0.0;
  for (const Obstacle& shape :
       extract(*map, grid.center(grid.width / 2, grid.height / 2), everywhere)) {
    EXPECT_LT(shape.a, size);
    if (shape.a <= 0.75 * grid.resolution) continue;
    for (double share = 0.1; share <= 1.0; share += 0.1)
      for (double phase = 0.0; phase < 6.29; phase += 0.02 / shape.a) {
        const double x = share * shape.a * std::cos(phase), y = share * shape.b * std::sin(phase);
        const double c = std::cos(shape.angle), s = std::sin(shape.angle);
        deepest =
            std::max(deepest, depth.at(shape.p_MO + Eigen::Vector2d{c * x - s * y, s * x + c * y}));
      }
  }
  return deepest;
}

void expect_no_deep_shape(const std::shared_ptr<const StaticMap>& map) {
  for (const double max_excess : {0.02, 0.03, 0.06, 0.2}) {
    // The fit samples every 4 cm, so that half of this may pass between two samples.
    EXPECT_LE(deepest_point(map, {.max_excess = max_excess}), max_excess + 0.02);
  }
}

const Footprint kMir = rectangle(0.89, 0.58, 0.038);
const Footprint kJackal = rectangle(0.508, 0.43, 0.0);

TEST(Extractor, CoversEveryCellOfRandomWorlds) {
  for (unsigned seed = 0; seed < 60; ++seed) expect_covered(random_world(seed), 10);
}

TEST(Extractor, CoversEveryCellOfTheProjectsMaps) {
  for (const char* name : {"forest", "corridor", "slalom"})
    expect_covered(load_world(project_map(name)), 200);
}

TEST(Extractor, CoversEveryCellOfARealBuilding) {
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  expect_covered(load_world(building_map()), 200);
}

TEST(Extractor, CoversWithAnyParameters) {
  for (const ExtractorParams& params :
       {ExtractorParams{.range = 0.7, .max_excess = 0.01, .smallest_gap = 0.0, .tile = 1.0},
        ExtractorParams{.range = 8.0, .max_excess = 0.5, .smallest_gap = 2.0, .tile = 20.0}})
    for (unsigned seed = 0; seed < 10; ++seed) {
      const auto map = random_world(seed);
      std::mt19937 random{seed};
      const Eigen::Vector2d p_MB = random_point(random, map->grid());
      ASSERT_EQ(uncovered_cells(*map, p_MB, params.range, extract(*map, p_MB, params)), 0);
    }
}

TEST(Extractor, LosesFewOfTheFreePoses) {
  expect_tight("forest", load_world(project_map("forest")), kMir, 0.05);
  expect_tight("corridor", load_world(project_map("corridor")), kMir, 0.15);
  expect_tight("slalom", load_world(project_map("slalom")), kMir, 0.15);
}

TEST(Extractor, LosesFewOfTheFreePosesInARealBuilding) {
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  expect_tight("building", load_world(building_map()), kJackal, 0.15);
}

TEST(Extractor, ReachesNowhereDeepIntoFreeSpace) {
  for (unsigned seed = 0; seed < 20; ++seed) expect_no_deep_shape(random_world(seed));
  for (const char* name : {"forest", "corridor", "slalom"})
    expect_no_deep_shape(load_world(project_map(name)));
}

TEST(Extractor, ReachesNowhereDeepIntoFreeSpaceOfARealBuilding) {
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  expect_no_deep_shape(load_world(building_map()));
}

TEST(Extractor, MakesOneCircleOfAPoleAndFewEllipsesOfAWall) {
  const auto map = load_world(project_map("forest"));
  const auto shapes = extract(*map, {0.0, 0.0}, {.range = 10.0});
  const auto circles = std::count_if(shapes.begin(), shapes.end(),
                                     [](const Obstacle& shape) { return shape.a == shape.b; });
  EXPECT_GE(circles, 16);
  EXPECT_LE(shapes.size(), 16 + 4 * 4);
}

TEST(Extractor, LeavesTheDoorsOfTheCorridorOpen) {
  const auto map = load_world(project_map("corridor"));
  Extractor extractor(map, {});
  for (const auto& [door, heading] : {std::pair{Eigen::Vector2d{5.025, 1.0}, 1.5708},
                                      std::pair{Eigen::Vector2d{11.425, -1.0}, -1.5708}}) {
    const auto shapes = extractor.near(door);
    for (double along = -0.6; along <= 0.6; along += 0.05) {
      const Pose2 X_MB{door.x(), door.y() + along, heading};
      for (const Obstacle& shape : shapes) EXPECT_FALSE(overlaps(kMir, X_MB, shape));
    }
  }
}

TEST(Extractor, GivesTheSameShapesWhereverTheRobotIs) {
  const auto map = load_world(project_map("corridor"));
  Extractor near(map, {}), whole(map, {.range = 50.0});
  std::vector<Obstacle> all = whole.near({0.0, 0.0});
  std::set<std::uint32_t> ids;
  for (const Obstacle& shape : all) EXPECT_TRUE(ids.insert(shape.id).second) << "id twice";
  for (double x = 15.0; x > 0.0; x -= 0.37)
    for (const Obstacle& shape : near.near({x, 0.1}))
      EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Obstacle& other) {
        return other.id == shape.id && other.p_MO == shape.p_MO && other.a == shape.a &&
               other.b == shape.b && other.angle == shape.angle;
      }));
}

TEST(Extractor, ShapesAreProperEllipsesAtRest) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto map = random_world(seed);
    for (const Obstacle& shape : extract(*map, map->grid().center(40, 30), {.range = 10.0})) {
      EXPECT_TRUE(shape.p_MO.allFinite() && std::isfinite(shape.a) && std::isfinite(shape.angle));
      EXPECT_GE(shape.a, shape.b);
      EXPECT_GT(shape.b, 0.0);
      EXPECT_EQ(shape.v_MO, Eigen::Vector2d::Zero());
    }
  }
}

TEST(Extractor, CoversUnknownCellsIfTheyAreObstacles) {
  Grid grid{0.05, {0.0, 0.0}, 100, 100, std::vector<Cell>(10000, Cell::kUnknown)};
  for (int iy = 40; iy < 60; ++iy)
    for (int ix = 40; ix < 60; ++ix)
      grid.cells[static_cast<std::size_t>(iy * 100 + ix)] = Cell::kFree;
  const Eigen::Vector2d middle{2.5, 2.5};
  const StaticMap known(grid, false), cautious(grid, true);
  EXPECT_TRUE(extract(known, middle, {.range = 2.0}).empty());
  const auto shapes = extract(cautious, middle, {.range = 2.0});
  EXPECT_EQ(uncovered_cells(cautious, middle, 2.0, shapes), 0);
  for (const Obstacle& shape : shapes) EXPECT_GT(level(shape, middle), 1.0);
}

TEST(Extractor, RefusesNonsense) {
  const auto map = random_world(1);
  EXPECT_THROW(Extractor(map, {.range = -1.0}), std::invalid_argument);
  Extractor extractor(map, {});
  EXPECT_TRUE(extractor.near({std::numeric_limits<double>::quiet_NaN(), 0.0}).empty());
  EXPECT_TRUE(extractor.near({1e300, -1e300}).empty());
}

}  // namespace
}  // namespace tandem
