// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/slice.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "support/paths.hpp"
#include "tandem/map/octomap_file.hpp"

namespace tandem {
namespace {

// State of a cell, computed from every voxel of its column that reaches into the band.
Cell state_by_force(const octomap::OcTree& tree, const Eigen::Vector2d& p, double low,
                    double high) {
  Cell state = Cell::kUnknown;
  const double r = tree.getResolution();
  for (int iz = -200; iz < 200; ++iz) {
    if (!(iz * r < high - 1e-9 && (iz + 1) * r > low + 1e-9)) continue;
    const auto* node = tree.search(p.x(), p.y(), (iz + 0.5) * r);
    if (node == nullptr) continue;
    if (tree.isNodeOccupied(node)) return Cell::kOccupied;
    state = Cell::kFree;
  }
  return state;
}

octomap::OcTree random_tree(unsigned seed, double resolution) {
  octomap::OcTree tree(resolution);
  std::mt19937 random{seed};
  std::uniform_int_distribution<int> index(-14, 14), extent(1, 12);
  for (int i = 0; i < 12; ++i) {  // blocks, so that some are pruned to large leaves
    const int x = index(random), y = index(random), z = index(random), n = extent(random);
    for (int dx = 0; dx < n; ++dx)
      for (int dy = 0; dy < n; ++dy)
        for (int dz = 0; dz < n; ++dz)
          tree.setNodeValue((x + dx + 0.5) * resolution, (y + dy + 0.5) * resolution,
                            (z + dz + 0.5) * resolution, i % 3 == 0 ? 2.0F : -2.0F, true);
  }
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

TEST(Slice, MatchesTheStateOfEveryVoxelInTheBand) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const octomap::OcTree tree = random_tree(seed, seed % 2 == 0 ? 0.1 : 0.07);
    const SliceParams params{.z_min = -0.3 + 0.05 * (seed % 5), .z_max = 0.45, .floor = 0.1};
    const Grid grid = slice(tree, params);
    for (int iy = 0; iy < grid.height; ++iy)
      for (int ix = 0; ix < grid.width; ++ix)
        ASSERT_EQ(grid.at(ix, iy),
                  state_by_force(tree, grid.center(ix, iy), params.z_min + 0.1, 0.55));
  }
}

TEST(Slice, OfAMessagesBytesIsThatOfItsTree) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const octomap::OcTree tree = random_tree(seed, 0.1);
    const auto bytes = encode_octomap(tree);
    const SliceParams params{
        .z_min = -0.3 + 0.05 * (seed % 5), .z_max = 0.45, .drop_off = seed % 2 == 0 ? 0.0 : 0.5};
    const Grid of_tree = slice(tree, params),
               of_bytes = slice_octomap({.resolution = 0.1}, bytes, params);
    EXPECT_EQ(of_bytes.resolution, of_tree.resolution);
    EXPECT_EQ(of_bytes.origin, of_tree.origin);
    EXPECT_EQ(of_bytes.width, of_tree.width);
    EXPECT_EQ(of_bytes.cells, of_tree.cells);
  }
}

TEST(Slice, SpansTheTreesBoundingBox) {
  const octomap::OcTree tree = random_tree(3, 0.1);
  const Grid grid = slice(tree, {});
  double x0, y0, z0, x1, y1, z1;
  tree.getMetricMin(x0, y0, z0);
  tree.getMetricMax(x1, y1, z1);
  EXPECT_NEAR(grid.origin.x(), x0, 1e-9);
  EXPECT_NEAR(grid.origin.y(), y0, 1e-9);
  EXPECT_NEAR(grid.origin.x() + grid.resolution * grid.width, x1, 1e-9);
  EXPECT_NEAR(grid.origin.y() + grid.resolution * grid.height, y1, 1e-9);
}

TEST(Slice, ASharedFaceIsNotAnOverlap) {
  octomap::OcTree tree(0.1);
  tree.updateNode(octomap::point3d(0.05F, 0.05F, 0.05F), true);  // z from 0 to 0.1
  EXPECT_EQ(slice(tree, {.z_min = 0.1, .z_max = 1.0}).at(0, 0), Cell::kUnknown);
  EXPECT_EQ(slice(tree, {.z_min = 0.099, .z_max = 1.0}).at(0, 0), Cell::kOccupied);
  EXPECT_EQ(slice(tree, {.z_min = -1.0, .z_max = 0.0}).at(0, 0), Cell::kUnknown);
  EXPECT_EQ(slice(tree, {.z_min = -1.0, .z_max = 0.001}).at(0, 0), Cell::kOccupied);
  EXPECT_EQ(slice(tree, {.z_min = 50.0, .z_max = 60.0}).at(0, 0), Cell::kUnknown);
}

TEST(Slice, RefusesAnEmptyBandAndAPlaneWithoutMeasure) {
  octomap::OcTree tree(0.01);
  EXPECT_TRUE(slice(tree, {}).cells.empty());
  tree.updateNode(octomap::point3d(-300.0F, -300.0F, 0.5F), true);
  EXPECT_THROW((void)slice(tree, {.z_min = 1.0, .z_max = 1.0}), std::invalid_argument);
  EXPECT_NO_THROW((void)slice(tree, {}));
  tree.updateNode(octomap::point3d(300.0F, 300.0F, 0.5F), true);
  EXPECT_THROW((void)slice(tree, {}), std::runtime_error);
}

// 3 m × 1 m of space observed from z = −0.5 m to 0.5 m, with a floor just below 0 for x < 1 m, a
// step of 0.1 m down from there to 2 m, and a hole beyond it in which nothing was observed below.
octomap::OcTree stairs() {
  octomap::OcTree tree(0.05);
  for (int ix = 0; ix < 60; ++ix)
    for (int iy = 0; iy < 20; ++iy)
      for (int iz = -10; iz < 10; ++iz) {
        const int floor = ix < 20 ? -1 : ix < 40 ? -3 : -100;
        if (iz >= floor)
          tree.setNodeValue(0.05 * (ix + 0.5), 0.05 * (iy + 0.5), 0.05 * (iz + 0.5),
                            iz == floor ? 2.0F : -2.0F, true);
      }
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

// State along the middle of the stairs at x [m].
Cell on_stairs(const SliceParams& params, double x) {
  return slice(stairs(), params).at(static_cast<int>(x / 0.05), 10);
}

TEST(Slice, TakesAMissingFloorForAnObstacleIfAsked) {
  for (const double x : {0.5, 1.5, 2.5}) EXPECT_EQ(on_stairs({}, x), Cell::kFree);
  const SliceParams deep{.drop_off = 0.2}, shallow{.drop_off = 0.08}, deeper{.drop_off = 0.7};
  EXPECT_EQ(on_stairs(deep, 0.97), Cell::kFree);
  EXPECT_EQ(on_stairs(deep, 1.5), Cell::kFree);  // a step of 0.1 m
  EXPECT_EQ(on_stairs(deep, 1.97), Cell::kFree);
  EXPECT_EQ(on_stairs(deep, 2.03), Cell::kOccupied);
  EXPECT_EQ(on_stairs(shallow, 0.97), Cell::kFree);
  EXPECT_EQ(on_stairs(shallow, 1.03), Cell::kOccupied);
  EXPECT_EQ(on_stairs(deeper, 2.5), Cell::kFree);  // never observed this far down
}

TEST(Slice, MeasuresADropOffFromTheFloor) {
  EXPECT_EQ(on_stairs({.floor = -0.1, .drop_off = 0.08}, 1.5), Cell::kFree);
  EXPECT_EQ(on_stairs({.floor = -0.1, .drop_off = 0.08}, 2.5), Cell::kOccupied);
}

TEST(Slice, UnmappedFloorIsNotADropOff) {
  octomap::OcTree tree(0.05);
  tree.updateNode(octomap::point3d(0.025F, 0.025F, 0.525F), false);
  EXPECT_EQ(slice(tree, {.drop_off = 0.1}).at(0, 0), Cell::kFree);
}

TEST(Slice, RefusesABandThatBeginsBelowTheDropOff) {
  EXPECT_THROW((void)slice(stairs(), {.z_min = -0.2, .drop_off = 0.1}), std::invalid_argument);
  EXPECT_THROW((void)slice(stairs(), {.drop_off = -0.1}), std::invalid_argument);
}

TEST(Slice, OfTheRealBuildingHasItsCorridorFree) {
  const auto file = test::shared_path("maps/geb079.bt");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const Grid grid = slice(*load_octomap(file), {.z_min = 0.10, .z_max = 1.0});
  EXPECT_NEAR(grid.resolution, 0.08, 1e-9);
  for (const double x : {-4.0, 0.0, 5.0, 20.0, 25.0}) {
    const Eigen::Vector2d c = (Eigen::Vector2d{x, 0.0} - grid.origin) / grid.resolution;
    EXPECT_EQ(grid.at(static_cast<int>(c.x()), static_cast<int>(c.y())), Cell::kFree) << x;
  }
}

}  // namespace
}  // namespace tandem
