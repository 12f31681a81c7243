// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/extractor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <set>

#include "obstacle_extractor/loss_worlds.hpp"
#include "obstacle_extractor/worlds.hpp"
#include "support/instrumented.hpp"

namespace tandem {
namespace {

using namespace test;

void expect_covered(const std::shared_ptr<const StaticMap>& map, unsigned poses) {
  const ExtractorParams params;
  Extractor extractor(map, params);
  std::mt19937 random{7};
  for (unsigned i = 0; i < poses; ++i) {
    const Eigen::Vector2d p_MB = random_point(random, map->grid());
    ASSERT_EQ(uncovered_cells(*map, p_MB, params.range, extractor.near(p_MB)), 0)
        << "at " << p_MB.transpose();
  }
}

constexpr const char* kNoStatistic = "instrumented code is too slow for a statistic";

// Along drives, at most 5 % of the poses that the outline can reach without contact are lost, and
// nowhere are there more than 32 shapes within 3 m.
void expect_tight(const LossWorlds& group) {
  const Loss loss = group.measure({});
  std::printf(
      "%-16s %4.1f %% lost; shapes within 3 m: mean %.1f, median %d, 90 %% up to %d, most %d\n",
      group.name, 100.0 * loss.share(), loss.mean_shapes(), loss.shapes_at(0.5),
      loss.shapes_at(0.9), loss.shapes_at(1.0));
  EXPECT_GT(loss.poses, 0);
  EXPECT_GT(loss.poses, 1e5);
  EXPECT_LE(loss.share(), 0.05);
  EXPECT_LE(loss.shapes_at(1.0), 32);
}

// The largest depth of any shape in free space, measured on the whole map. Shapes around a single
// cell are excluded: the cell determines their size.
double deepest_point(const std::shared_ptr<const StaticMap>& map, const ExtractorParams& params) {
  const Grid& grid = map->grid();
  const Eigen::Vector2d middle = grid.center(grid.width / 2, grid.height / 2);
  const FreeRegions places(*map, params.smallest_gap);
  const FreeSpace space(*map, places, {-50, -50, grid.width + 50, grid.height + 50}, 0, 1.0);
  const double size = grid.resolution * (grid.width + grid.height);
  ExtractorParams everywhere = params;
  everywhere.range = 50.0;
  double deepest = 0.0;
  int looked_at = 0;
  for (const Obstacle& shape : extract(*map, middle, everywhere)) {
    EXPECT_LT(shape.a, size);
    if (shape.a <= 0.75 * grid.resolution) continue;
    ++looked_at;
    for (double share = 0.1; share <= 1.0; share += 0.1)
      for (double phase = 0.0; phase < 6.29; phase += 0.02 / shape.a) {
        const double x = share * shape.a * std::cos(phase), y = share * shape.b * std::sin(phase);
        const double c = std::cos(shape.angle), s = std::sin(shape.angle);
        deepest = std::max(deepest,
                           space.depth(shape.p_MO + Eigen::Vector2d{c * x - s * y, s * x + c * y}));
      }
  }
  EXPECT_GT(looked_at, 0);
  return deepest;
}

void expect_no_deep_shape(const std::shared_ptr<const StaticMap>& map,
                          const std::vector<double>& excesses = {0.03, 0.25}) {
  for (const double max_excess : excesses) {
    // The fit samples every 4 cm, so that half of this may pass between two samples.
    EXPECT_LE(deepest_point(map, {.max_excess = max_excess}), max_excess + 0.02);
  }
}

TEST(Extractor, CoversEveryCellOfRandomWorlds) {
  for (unsigned seed = 0; seed < samples(40, 4, 200); ++seed)
    expect_covered(random_world(seed), 10);
}

TEST(Extractor, CoversEveryCellOfTheProjectsMaps) {
  int maps = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(project_map("forest").parent_path())) {
    if (file.path().extension() != ".bt") continue;
    SCOPED_TRACE(file.path());
    expect_covered(load_world(file.path()), samples(40, 2, 100));
    ++maps;
  }
  EXPECT_GE(maps, 6);
}

TEST(Extractor, CoversEveryCellOfARealBuilding) {
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  expect_covered(load_world(building_map()), samples(60, 1));
}

TEST(Extractor, CoversWithAnyParameters) {
  for (const ExtractorParams& params :
       {ExtractorParams{.range = 0.7, .max_excess = 0.01, .smallest_gap = 0.0, .tile = 1.0},
        ExtractorParams{.range = 8.0, .max_excess = 0.5, .smallest_gap = 2.0, .tile = 20.0}})
    for (unsigned seed = 0; seed < samples(10, 2); ++seed) {
      const auto map = random_world(seed);
      std::mt19937 random{seed};
      const Eigen::Vector2d p_MB = random_point(random, map->grid());
      ASSERT_EQ(uncovered_cells(*map, p_MB, params.range, extract(*map, p_MB, params)), 0);
    }
}

// The same slice of a BARN world, of a map a fifth as high: its cylinders are upright.
std::shared_ptr<const StaticMap> low_barn_world(int number) {
  constexpr double kHigh = 0.2;  // [m]
  MapDescription description = load_barn_world(barn_file(), number);
  description.high.z() = kHigh;
  for (Solid& solid : description.solids) solid.z_high = kHigh;
  const auto tree = build_octomap(description);
  return std::make_shared<StaticMap>(slice(*tree, {.z_min = 0.10, .z_max = 1.0}));
}

TEST(Extractor, CoversEveryCellOfBarnWorlds) {
  if (!std::filesystem::exists(barn_file())) GTEST_SKIP() << barn_file() << " is not here";
  const auto numbers = barn_world_numbers(barn_file());
  EXPECT_EQ(numbers.size(), 150U);
  EXPECT_EQ(low_barn_world(numbers[0])->grid().cells, barn_world(numbers[0])->grid().cells);
  for (std::size_t i = 0; i < numbers.size(); i += samples(5, 75, 1)) {
    SCOPED_TRACE(numbers[i]);
    expect_covered(low_barn_world(numbers[i]), samples(3, 1, 30));
  }
}

TEST(Extractor, LosesFewPosesInBarnWorlds) {
  if (kInstrumented) GTEST_SKIP() << kNoStatistic;
  if (!std::filesystem::exists(barn_file())) GTEST_SKIP() << barn_file() << " is not here";
  expect_tight(barn_loss_worlds(static_cast<int>(samples(30, 30, 1))));
}

TEST(Extractor, LosesFewPosesInARealBuilding) {
  if (kInstrumented) GTEST_SKIP() << kNoStatistic;
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  expect_tight(building_loss_worlds("geb079, Jackal", kJackal, kJackalWidth, 12));
}

TEST(Extractor, LosesFewPosesOfALongerRobotInARealBuilding) {
  if (kInstrumented) GTEST_SKIP() << kNoStatistic;
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  expect_tight(building_loss_worlds("geb079, MiR", kMir, kMirWidth, 12));
}

TEST(Extractor, FitsCoarserShapesWhereATileNeedsTooMany) {
  Grid grid{0.05, {0.0, 0.0}, 80, 80, std::vector<Cell>(6400, Cell::kFree)};
  std::mt19937 random{1};
  const auto any = [&random](int below) { return static_cast<int>(random() % 1000U) % below; };
  for (int group = 0; group < 8; ++group) {
    const int ix = any(70), iy = any(70);
    for (int i = 0; i < 3; ++i)
      grid.cells[grid.index(ix + any(10), iy + any(10))] = Cell::kOccupied;
  }
  const StaticMap map{std::move(grid)};
  const Eigen::Vector2d middle{2.0, 2.0};
  const auto shapes_of = [&](int most) {
    const ExtractorParams params{.range = 50.0, .shapes_per_tile = most};
    const auto shapes = extract(map, middle, params);
    EXPECT_EQ(uncovered_cells(map, middle, params.range, shapes), 0);
    return shapes.size();
  };
  EXPECT_LT(shapes_of(8), shapes_of(12));
  EXPECT_LT(shapes_of(12), shapes_of(1000));
}

// The plane of the shapes alone, as a map of half the cells' size.
StaticMap map_of(const std::vector<Obstacle>& shapes, const Grid& like) {
  Grid grid{0.5 * like.resolution, like.origin, 2 * like.width, 2 * like.height, {}};
  grid.cells.resize(4 * like.cells.size());
  for (int iy = 0; iy < grid.height; ++iy)
    for (int ix = 0; ix < grid.width; ++ix) {
      const bool inside = std::any_of(shapes.begin(), shapes.end(), [&](const Obstacle& shape) {
        return contains(shape, grid.center(ix, iy));
      });
      grid.cells[grid.index(ix, iy)] = inside ? Cell::kOccupied : Cell::kFree;
    }
  return StaticMap{std::move(grid)};
}

// Poles 0.7 m apart: a Jackal fits between any two, but a shape may span several poles, as long as
// the places between the poles stay connected for it with 4.5 cm to spare on either side.
TEST(Extractor, PrefersTooManyShapesToClosingAPassage) {
  Grid grid{0.05, {0.0, 0.0}, 80, 80, std::vector<Cell>(6400, Cell::kFree)};
  for (int iy = 4; iy < 80; iy += 14)
    for (int ix = 4; ix < 80; ix += 14) grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
  const StaticMap map{std::move(grid)};
  const ExtractorParams params{
      .range = 10.0, .max_excess = 0.4, .width = kJackalWidth, .shapes_per_tile = 1};
  const auto shapes = extract(map, {2.0, 2.0}, params);
  EXPECT_LT(shapes.size(), 36U);
  EXPECT_GT(shapes.size(), 6U) << "a wall for each row";
  const FreeRegions places(map_of(shapes, map.grid()), kJackalWidth + 2.0 * 0.045);
  const int region = places.region_at({0.575, 0.575});
  EXPECT_NE(region, 0);
  for (double y = 0.575; y < 3.5; y += 0.7)
    for (double x = 0.575; x < 3.5; x += 0.7) EXPECT_EQ(places.region_at({x, y}), region);
}

// Among many poles the shapes get coarser and a passage may get narrower, but not below this width.
// In world 115 it would shrink to 0.55 m without the protection of passages.
TEST(Extractor, KeepsThePassageThroughTheMostCrowdedWorldsOpen) {
  if (!std::filesystem::exists(barn_file())) GTEST_SKIP() << barn_file() << " is not here";
  if (kInstrumented) GTEST_SKIP() << "the worlds of the other tests run the same code";
  for (const auto& [number, wide] : {std::pair{115, 0.58}, {181, 0.50}, {206, 0.50}}) {
    SCOPED_TRACE(number);
    const auto map = barn_world(number);
    const auto shapes = extract(*map, {-2.25, 8.0}, {.range = 20.0, .width = kJackalWidth});
    const FreeRegions places(map_of(shapes, map->grid()), wide);
    EXPECT_NE(places.region_at({-2.25, 3.0}), 0);
    EXPECT_EQ(places.region_at({-2.25, 3.0}), places.region_at({-2.25, 13.0}));
  }
}

TEST(Extractor, ReachesNowhereDeepIntoFreeSpace) {
  for (unsigned seed = 0; seed < samples(10, 2, 40); ++seed)
    expect_no_deep_shape(random_world(seed));
  if (kInstrumented) return;  // whole maps take minutes
  for (const char* name : {"forest", "corridor", "slalom"})
    expect_no_deep_shape(load_world(project_map(name)));
}

TEST(Extractor, ReachesNowhereDeepIntoFreeSpaceOfARealBuilding) {
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  if (kInstrumented) GTEST_SKIP() << "whole maps take minutes";
  expect_no_deep_shape(load_world(building_map()));
}

TEST(Extractor, MakesOneRoundShapeOfAPoleAndFewShapesOfAWall) {
  const auto map = load_world(project_map("forest"));
  const auto shapes = extract(*map, {0.0, 0.0}, {.range = 10.0});
  const auto round = std::count_if(shapes.begin(), shapes.end(), [](const Obstacle& shape) {
    return shape.a < 1.1 * shape.b && shape.a < 0.3;
  });
  EXPECT_EQ(round, 16);
  EXPECT_LE(shapes.size(), 16 + 4 * 5);
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

TEST(Extractor, ShapesAreProperAndAtRest) {
  for (unsigned seed = 0; seed < samples(20, 4); ++seed) {
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
  for (const Obstacle& shape : shapes) EXPECT_FALSE(contains(shape, middle));
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
