// SPDX-License-Identifier: Apache-2.0
#include "tandem/map/static_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "support/instrumented.hpp"

namespace tandem {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

double distance_to_cell(const Grid& grid, int ix, int iy, const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d d = (p_MQ - grid.center(ix, iy)).cwiseAbs();
  return (d.array() - 0.5 * grid.resolution).max(0.0).matrix().norm();
}

// Random cells of all three states: sparse, dense or in blocks.
Grid random_grid(std::mt19937& random) {
  std::uniform_int_distribution<int> size(1, 40);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Grid grid;
  grid.resolution = 0.03 + 0.1 * unit(random);
  grid.origin = {10.0 * unit(random) - 5.0, 10.0 * unit(random) - 5.0};
  grid.width = size(random);
  grid.height = size(random);
  const double density = std::pow(unit(random), 4.0);
  for (int i = 0; i < grid.width * grid.height; ++i) {
    const double u = unit(random);
    grid.cells.push_back(u < density         ? Cell::kOccupied
                         : u < 1.2 * density ? Cell::kUnknown
                                             : Cell::kFree);
  }
  return grid;
}

Eigen::Vector2d random_point(std::mt19937& random, const Grid& grid, double beyond) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Eigen::Vector2d size{grid.width * grid.resolution, grid.height * grid.resolution};
  return grid.origin.array() - beyond +
         (size.array() + 2.0 * beyond) * Eigen::Array2d{unit(random), unit(random)};
}

double distance_by_force(const StaticMap& map, const Eigen::Vector2d& p_MQ) {
  double d = kInf;
  for (int iy = -1; iy <= map.grid().height; ++iy)
    for (int ix = -1; ix <= map.grid().width; ++ix)
      if (map.is_obstacle(ix, iy)) d = std::min(d, distance_to_cell(map.grid(), ix, iy, p_MQ));
  return d;
}

TEST(StaticMap, DistanceIsALowerBoundWithinADiagonalOfTheTruth) {
  std::mt19937 random{1};
  for (unsigned trial = 0; trial < test::samples(200, 50); ++trial) {
    const StaticMap map(random_grid(random), trial % 2 == 0);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector2d p_MQ = random_point(random, map.grid(), 0.0);
      const double truth = distance_by_force(map, p_MQ), bound = map.distance(p_MQ);
      ASSERT_LE(bound, truth + 1e-12);
      if (truth == kInf) {
        ASSERT_EQ(bound, kInf);
      } else {
        ASSERT_GE(bound, truth - std::sqrt(2.0) * map.grid().resolution - 1e-6);
      }
      if (truth == 0.0) {
        ASSERT_EQ(bound, 0.0);
      }
    }
  }
}

TEST(StaticMap, DistanceIsALowerBoundOutsideOfTheGridToo) {
  std::mt19937 random{2};
  for (unsigned trial = 0; trial < test::samples(200, 50); ++trial) {
    const StaticMap map(random_grid(random), false);
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d p_MQ = random_point(random, map.grid(), 3.0);
      ASSERT_LE(map.distance(p_MQ), distance_by_force(map, p_MQ) + 1e-12);
    }
  }
}

TEST(StaticMap, OutsideIsAnObstacleIfTheUnknownIs) {
  const Grid grid{0.1, {0.0, 0.0}, 10, 10, std::vector<Cell>(100, Cell::kFree)};
  EXPECT_EQ(StaticMap(grid, true).distance({-3.0, 0.5}), 0.0);
  EXPECT_EQ(StaticMap(grid, false).distance({-3.0, 0.5}), kInf);
  EXPECT_NEAR(StaticMap(grid, true).distance({0.25, 0.55}), 0.25, 1e-6);
  const Footprint robot = rectangle(0.2, 0.2, 0.0);
  EXPECT_NEAR(StaticMap(grid, true).clearance(robot, {0.25, 0.55, 0.0}, 1.0), 0.15, 1e-9);
  EXPECT_EQ(StaticMap(grid, true).clearance(robot, {0.05, 0.55, 0.0}, 1.0), 0.0);
  EXPECT_EQ(StaticMap(grid, false).clearance(robot, {0.05, 0.55, 0.0}, 1.0), 1.0);
}

// Compares with a brute-force search over all squares of the map.
void expect_exact_clearance(std::mt19937& random,
                            const std::function<Footprint(std::mt19937&)>& random_robot) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 300; ++trial) {
    const StaticMap map(random_grid(random), false);
    const Footprint robot = random_robot(random);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector2d p = random_point(random, map.grid(), 0.5);
      const Pose2 X_MB{p.x(), p.y(), 7.0 * unit(random)};
      const double cap = i % 5 == 0 ? kInf : 2.0 * unit(random);
      double truth = cap;
      for (int iy = 0; iy < map.grid().height; ++iy)
        for (int ix = 0; ix < map.grid().width; ++ix)
          if (map.is_obstacle(ix, iy))
            truth = std::min(truth, distance_to_square(robot, X_MB, map.grid().center(ix, iy),
                                                       map.grid().resolution));
      ASSERT_DOUBLE_EQ(map.clearance(robot, X_MB, cap), truth);
    }
  }
}

TEST(StaticMap, ClearanceEqualsTheLeastDistanceToAnySquare) {
  std::mt19937 random{3};
  expect_exact_clearance(random, [](std::mt19937& draw) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    return rectangle(0.1 + unit(draw), 0.1 + unit(draw), 0.04 * unit(draw));
  });
}

// Forks in front of or behind a body, with the parts in any order.
TEST(StaticMap, ClearanceOfSeveralPartsEqualsTheLeastDistanceToAnySquare) {
  std::mt19937 random{8};
  expect_exact_clearance(random, [](std::mt19937& draw) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double width = 0.1 + 0.3 * unit(draw), fork = 0.02 + 0.1 * unit(draw);
    const double side = unit(draw) < 0.5 ? -1.0 : 1.0, root = 0.2 * unit(draw);
    const auto box = [](double x1, double y1, double x2, double y2) {
      const auto [left, right] = std::minmax(x1, x2);
      return ConvexPolygon{{left, y1}, {right, y1}, {right, y2}, {left, y2}};
    };
    std::vector<ConvexPolygon> parts{
        box(-0.2, -width, 0.2, width),
        box(side * root, width - fork, side * (root + 0.8 * unit(draw) + 0.01), width),
        box(side * root, -width, side * (root + 0.8 * unit(draw) + 0.01), fork - width)};
    std::shuffle(parts.begin(), parts.end(), draw);
    return polygons(std::move(parts));
  });
}

TEST(StaticMap, CellsNearAreThoseWhoseSquareIsWithinTheRadius) {
  std::mt19937 random{4};
  for (unsigned trial = 0; trial < test::samples(200, 50); ++trial) {
    const StaticMap map(random_grid(random), trial % 2 == 0);
    const Eigen::Vector2d p_MQ = random_point(random, map.grid(), 0.5);
    std::size_t expected = 0;
    for (int iy = 0; iy < map.grid().height; ++iy)
      for (int ix = 0; ix < map.grid().width; ++ix)
        if (map.is_obstacle(ix, iy) && distance_to_cell(map.grid(), ix, iy, p_MQ) <= 0.7)
          ++expected;
    const auto cells = map.cells_near(p_MQ, 0.7);
    EXPECT_EQ(cells.size(), expected);
  }
}

TEST(StaticMap, SquaresNearHoldTheNearestObstacleOutsideOfTheGridToo) {
  std::mt19937 random{5};
  for (unsigned trial = 0; trial < test::samples(200, 50); ++trial) {
    const StaticMap map(random_grid(random), trial % 2 == 0);
    const Eigen::Vector2d p_MQ = random_point(random, map.grid(), 0.0);
    const Footprint dot = rectangle(1e-6, 1e-6, 0.0);
    double nearest = 0.7;
    for (const auto& p_MC : map.squares_near(p_MQ, 0.7))
      nearest = std::min(
          nearest, distance_to_square(dot, {p_MQ.x(), p_MQ.y(), 0.0}, p_MC, map.grid().resolution));
    EXPECT_NEAR(nearest, map.clearance(dot, {p_MQ.x(), p_MQ.y(), 0.0}, 0.7), 1e-5);
  }
}

// The sweep must end on an obstacle (not too early), no later than the first sample inside one.
TEST(StaticMap, RaysEndOnTheFirstObstacle) {
  std::mt19937 random{5};
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 300; ++trial) {
    const StaticMap map(random_grid(random), trial % 2 == 0);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector2d p_MQ = random_point(random, map.grid(), trial % 4 == 1 ? 1.0 : 0.0);
      const double heading =
          i % 4 == 0 ? 0.5 * std::numbers::pi * (i / 4) : 20.0 * unit(random) - 10.0;
      const double range = map.cast_ray(p_MQ, heading, 3.0);
      ASSERT_GE(range, 0.0);
      ASSERT_LE(range, 3.0);
      const Eigen::Vector2d along{std::cos(heading), std::sin(heading)};
      if (range < 3.0) {
        ASSERT_LE(distance_by_force(map, p_MQ + range * along), 1e-6);
      }
      double first = 3.0;
      for (double t = 0.0; t < 3.0; t += 0.01) {
        const Eigen::Vector2d c = (p_MQ + t * along - map.grid().origin) / map.grid().resolution;
        if (map.is_obstacle(static_cast<int>(std::floor(c.x())),
                            static_cast<int>(std::floor(c.y())))) {
          first = t;
          break;
        }
      }
      ASSERT_LE(range, first + 1e-9);
    }
  }
}

TEST(StaticMap, NumbersThatAreNotFiniteCountAsContact) {
  const StaticMap map({0.1, {0.0, 0.0}, 10, 10, std::vector<Cell>(100, Cell::kFree)}, false);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(map.distance({nan, 0.5}), 0.0);
  EXPECT_EQ(map.distance({kInf, 0.5}), 0.0);
  EXPECT_EQ(map.clearance(rectangle(1.0, 0.5, 0.0), {0.5, nan, 0.0}, 1.0), 0.0);
  EXPECT_EQ(map.cast_ray({nan, 0.5}, 0.0, 1.0), 0.0);
  EXPECT_TRUE(map.cells_near({nan, 0.5}, 1.0).empty());
  EXPECT_EQ(map.distance({1e300, 0.5}), kInf);
}

TEST(StaticMap, RefusesAGridWhoseSizesContradict) {
  EXPECT_THROW(StaticMap({0.1, {0.0, 0.0}, 3, 3, std::vector<Cell>(8)}), std::invalid_argument);
  EXPECT_THROW(StaticMap({0.0, {0.0, 0.0}, 1, 1, std::vector<Cell>(1)}), std::invalid_argument);
  EXPECT_NO_THROW(StaticMap({0.1, {0.0, 0.0}, 0, 0, {}}));
}

}  // namespace
}  // namespace tandem
