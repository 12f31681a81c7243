// SPDX-License-Identifier: Apache-2.0
// Tests the extractor on maps that change: live sensing, and a window that moves with the robot.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <random>

#include "obstacle_extractor/worlds.hpp"
#include "support/instrumented.hpp"
#include "tandem/map/overlay.hpp"
#include "tandem/obstacle_extractor/extractor.hpp"

namespace tandem {
namespace {

using namespace test;

// The input of a robot with live sensing: a window that moves with it, in which objects appear and
// disappear.
class ChangingWorld {
 public:
  explicit ChangingWorld(unsigned seed)
      : random_{seed}, base_{load_world(project_map("forest"))->grid()} {}
  std::shared_ptr<const StaticMap> next(const Eigen::Vector2d& p_MB) {
    for (int i = 0; i < 3; ++i) {
      Cell& cell = base_.cells[random_() % base_.cells.size()];
      cell = cell == Cell::kOccupied ? Cell::kFree : Cell::kOccupied;
    }
    return window(base_, p_MB, 4.0);
  }
  static std::shared_ptr<const StaticMap> window(const Grid& base, const Eigen::Vector2d& p_MB,
                                                 double reach) {
    return std::make_shared<const StaticMap>(
        overlay(base, Grid{base.resolution, base.origin, 0, 0, {}}, p_MB, reach));
  }

 private:
  std::mt19937 random_;
  Grid base_;
};

TEST(ChangingMap, EveryCellIsCoveredAtOnce) {
  ChangingWorld world(5);
  const ExtractorParams params{.range = 2.5, .tile = 2.0};
  const auto place = [](int n) { return Eigen::Vector2d{-4.0 + 0.2 * n, -3.0 + 0.05 * n}; };
  Extractor extractor(world.next(place(0)), params);
  for (int n = 0; n < 30; ++n) {
    const auto map = world.next(place(n));
    extractor.update(map);
    ASSERT_EQ(uncovered_cells(*map, place(n), params.range, extractor.near(place(n))), 0) << n;
    if (n % 7 == 0) (void)extractor.refresh_near(place(n), params.range, 3);
  }
}

// Compares shapes by id: counts those that moved, and those well within range that disappeared.
struct Watch {
  std::map<std::uint32_t, Obstacle> shapes = {};
  int matched = 0, moved = 0, gone = 0;

  void look(const std::vector<Obstacle>& now, const Eigen::Vector2d& p_MB, double range,
            double least) {
    std::map<std::uint32_t, Obstacle> next;
    for (const Obstacle& shape : now) next[shape.id] = shape;
    for (const auto& [id, last] : shapes) {
      const auto found = next.find(id);
      const bool is_within = (last.p_MO - p_MB).norm() < range - last.a - least;
      if (found == next.end()) {
        gone += is_within ? 1 : 0;
        continue;
      }
      ++matched;
      moved += (found->second.p_MO - last.p_MO).norm() >= least ? 1 : 0;
    }
    shapes = std::move(next);
  }
};

constexpr int kCoarser = static_cast<int>(samples(1, 10));

// The robot moves in steps of 5 cm and sees the objects in the node's window. No shape may move
// because of that. Only if more of the free space around a tile becomes visible is the tile fitted
// again, which may replace some of its shapes. Ids keep their position by construction; a flicker
// that a user would see counts as a disappearance.
void expect_stable(const char* name, const Grid& world, const Eigen::Vector2d& from,
                   const Eigen::Vector2d& to) {
  constexpr double kReach = 10.0;
  const ExtractorParams params;
  Extractor extractor(ChangingWorld::window(world, from, kReach), params);
  Watch updates, all;
  const double step = 0.05 * kCoarser;
  const int steps = static_cast<int>((to - from).norm() / step);
  for (int n = 0; n <= steps; ++n) {
    const Eigen::Vector2d p_MB = from + n * (to - from) / steps;
    extractor.update(ChangingWorld::window(world, p_MB, kReach));
    updates.look(extractor.near(p_MB), p_MB, params.range - step, world.resolution);
    for (int i = 0; i < 4 && extractor.refresh_near(p_MB, params.range, 3); ++i) {
    }
    const auto refreshed = extractor.near(p_MB);
    all.look(refreshed, p_MB, params.range - step, world.resolution);
    updates.shapes.clear();
    for (const Obstacle& shape : refreshed) updates.shapes[shape.id] = shape;
  }
  std::printf("%-8s %d shapes matched; fitted again, %d others took the place of some\n", name,
              all.matched, all.gone);
  EXPECT_GT(all.matched, 100);
  EXPECT_EQ(updates.moved, 0) << name;
  EXPECT_EQ(updates.gone, 0) << name;
  EXPECT_EQ(all.moved, 0) << name;
  EXPECT_LE(all.gone, 0.005 * kCoarser * all.matched) << name;
}

TEST(ChangingMap, ShapesStayWhereTheyAreWhileTheWindowMovesWithTheRobot) {
  for (const char* name : {"corridor", "ward"}) {
    const Grid world = load_world(project_map(name))->grid();
    const Eigen::Vector2d size =
        world.resolution * Eigen::Vector2d{1.0 * world.width, 1.0 * world.height};
    expect_stable(name, world, world.origin + 0.2 * size, world.origin + 0.8 * size);
  }
  if (!std::filesystem::exists(building_map())) GTEST_SKIP() << building_map() << " is not here";
  if (kInstrumented) GTEST_SKIP() << "the building takes minutes";
  expect_stable("geb079", load_world(building_map())->grid(), {-1.0, 0.0}, {12.0, 0.5});
}

// A removed object that stood alone disappears from the list immediately.
TEST(ChangingMap, ARemovedObjectIsNotAnObstacle) {
  Grid grid{0.05, {0.0, 0.0}, 200, 200, std::vector<Cell>(40000, Cell::kFree)};
  const auto empty = std::make_shared<const StaticMap>(grid);
  for (int i = 0; i < 10; ++i) grid.cells[grid.index(100 + i, 120)] = Cell::kOccupied;
  const auto bar = std::make_shared<const StaticMap>(grid);
  Extractor extractor(empty, {});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(extractor.near({5.0, 5.0}).empty());
    extractor.update(bar);
    EXPECT_EQ(uncovered_cells(*bar, {5.0, 5.0}, 4.0, extractor.near({5.0, 5.0})), 0);
    extractor.update(empty);
  }
}

TEST(ChangingMap, NewCellsInARowGetOneRectangleUntilTheirTileIsFittedAgain) {
  for (const bool is_upright : {false, true}) {
    Grid grid{0.05, {0.0, 0.0}, 200, 200, std::vector<Cell>(40000, Cell::kFree)};
    for (int i = 0; i < 10; ++i) grid.cells[grid.index(100 + i, 120)] = Cell::kOccupied;
    Extractor extractor(std::make_shared<const StaticMap>(grid), {});
    const auto before = extractor.near({5.0, 5.0});
    for (int i = 0; i < 20; ++i)
      grid.cells[is_upright ? grid.index(90, 110 + i) : grid.index(100 + i, 90)] = Cell::kOccupied;
    const auto map = std::make_shared<const StaticMap>(grid);
    extractor.update(map);
    const auto after = extractor.near({5.0, 5.0});
    ASSERT_EQ(after.size(), before.size() + 1);
    EXPECT_EQ(after[0].id, before[0].id);
    EXPECT_TRUE(is_rectangle(after.back()));
    EXPECT_NEAR(after.back().a, 0.5, 1e-6);
    EXPECT_NEAR(after.back().b, 0.025, 1e-6);
    EXPECT_EQ(uncovered_cells(*map, {5.0, 5.0}, 4.0, after), 0);
    EXPECT_TRUE(extractor.refresh_near({5.0, 5.0}, 4.0, 0));
  }
}

// How often the tile of a flickering bar at p_MQ is refitted in 48 updates.
int refits_of_bar_at(const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d p_MB{5.0, 5.0};
  Grid grid{0.05, {0.0, 0.0}, 200, 200, std::vector<Cell>(40000, Cell::kFree)};
  const int ix = static_cast<int>(p_MQ.x() / 0.05), iy = static_cast<int>(p_MQ.y() / 0.05);
  for (int i = 0; i < 8; ++i) grid.cells[grid.index(ix + i, iy)] = Cell::kOccupied;
  Extractor extractor(std::make_shared<const StaticMap>(grid), {.tile = 2.0});
  (void)extractor.near(p_MB);
  int refits = 0;
  for (int update = 0; update < 48; ++update) {
    Cell& end = grid.cells[grid.index(ix + 8, iy)];
    end = end == Cell::kFree ? Cell::kOccupied : Cell::kFree;
    extractor.update(std::make_shared<const StaticMap>(grid));
    (void)extractor.near(p_MB);
    while (extractor.refresh_near(p_MB, 4.0, 3)) ++refits;
  }
  return refits;
}

TEST(ChangingMap, FarTilesAreRefittedLessOften) {
  EXPECT_EQ(refits_of_bar_at({5.2, 5.2}), 16);  // in the robot's tile: after 3 updates
  EXPECT_EQ(refits_of_bar_at({8.2, 5.2}), 4);   // its tile is 3 m away: after 12
}

TEST(ChangingMap, RefreshedShapesAreThoseOfTheNewMapAlone) {
  ChangingWorld world(6);
  const ExtractorParams params{.range = 2.5, .tile = 2.0};
  const Eigen::Vector2d p_MB{-1.0, -2.0};
  const auto first = world.next({-1.0, -3.0});
  Extractor followed(first, params);
  (void)followed.near(p_MB);
  std::shared_ptr<const StaticMap> map;
  for (int n = 0; n < 5; ++n) {
    followed.update(map = world.next({-1.0 + 0.3 * n, -3.0 + 0.3 * n}));
    (void)followed.near(p_MB);
  }
  while (followed.refresh_near(p_MB, params.range, 0)) {
  }
  Extractor alone(first, params);
  alone.update(map);
  expect_same(followed.near(p_MB), alone.near(p_MB));
}

TEST(ChangingMap, OnlyTilesThatChangedAreFittedAgain) {
  const auto before = load_world(project_map("forest"));
  Grid grid = before->grid();
  const Eigen::Vector2d p_MB{0.0, -2.0}, changed{2.6, -3.1};
  const Eigen::Vector2d cell = (changed - grid.origin) / grid.resolution;
  grid.cells[grid.index(static_cast<int>(cell.x()), static_cast<int>(cell.y()))] = Cell::kOccupied;
  Extractor extractor(before, {});
  const auto old = extractor.near(p_MB);
  extractor.update(std::make_shared<const StaticMap>(grid));
  int kept = 0, more = 0;
  for (const Obstacle& shape : extractor.near(p_MB)) {
    const bool is_kept = std::any_of(old.begin(), old.end(), [&](const Obstacle& other) {
      return other.id == shape.id && other.p_MO == shape.p_MO && other.a == shape.a;
    });
    ++(is_kept ? kept : more);
    EXPECT_TRUE(is_kept || (shape.p_MO - changed).norm() < 6.0);
  }
  EXPECT_GT(more, 0);
  EXPECT_GT(kept, more);
}

}  // namespace
}  // namespace tandem
