// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/ellipse_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "tandem/map/static_map.hpp"

namespace tandem {
namespace {

constexpr FitLimits kLoose{.excess = {9.0, 9.0, 9.0}, .price = 9.0, .circle_bonus = 0.0};

// A room of 6 m × 6 m with some occupied cells in it, and the corners of these.
struct Room {
  explicit Room(const std::vector<CellIndex>& occupied) {
    constexpr int kCells = 120;
    Grid grid{0.05, {0.0, 0.0}, kCells, kCells, std::vector<Cell>(kCells * kCells, Cell::kFree)};
    Points corners;
    for (const auto& [ix, iy] : occupied) {
      grid.cells[grid.index(ix, iy)] = Cell::kOccupied;
      for (const double x : {0.05 * ix, 0.05 * (ix + 1)})
        for (const double y : {0.05 * iy, 0.05 * (iy + 1)}) corners.push_back({x, y});
    }
    hull = convex_hull(corners);
    map = std::make_unique<StaticMap>(std::move(grid));
    places = std::make_unique<FreeRegions>(*map, 0.42);
    space = std::make_unique<FreeSpace>(*map, *places, CellRect{0, 0, kCells, kCells}, 0);
  }
  [[nodiscard]] EllipseFit fit(const FitLimits& limits = kLoose) const {
    return fit_ellipse(hull, *space, limits);
  }

  Points hull;
  std::unique_ptr<StaticMap> map;
  std::unique_ptr<FreeRegions> places;
  std::unique_ptr<FreeSpace> space;
};

// From one cell to a wall of 2 m, at any angle, 1 to 4 cells thick.
std::vector<CellIndex> random_wall(unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> angle{0.0, 3.14}, length{0.0, 2.0};
  const double turn = angle(random), end = length(random);
  const double thick = 0.05 * static_cast<double>(1 + random() % 4);
  std::vector<CellIndex> cells;
  for (double s = 0.0; s <= end; s += 0.02)
    for (double across = 0.0; across < thick; across += 0.02)
      cells.push_back(
          {static_cast<int>((3.0 + s * std::cos(turn) - across * std::sin(turn)) / 0.05),
           static_cast<int>((3.0 + s * std::sin(turn) + across * std::cos(turn)) / 0.05)});
  return cells;
}

// 1 on the outline.
double inside(const Obstacle& shape, const Eigen::Vector2d& p_MQ) {
  const Eigen::Vector2d p_OQ = Eigen::Rotation2Dd(-shape.angle) * (p_MQ - shape.p_MO);
  return std::hypot(p_OQ.x() / shape.a, p_OQ.y() / shape.b);
}

TEST(EllipseFit, ContainsEveryCellOfAnyWall) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Room room(random_wall(seed));
    for (const double price : {9.0, 0.1, 0.0}) {
      FitLimits limits = kLoose;
      limits.price = price;
      const EllipseFit fit = room.fit(limits);
      EXPECT_GE(fit.shape.a, fit.shape.b) << seed;
      EXPECT_GT(fit.shape.b, 0.0) << seed;
      for (const auto& corner : room.hull) EXPECT_LE(inside(fit.shape, corner), 1.0) << seed;
    }
  }
}

TEST(EllipseFit, TakesNoMoreThanTheCircleAndWhatItReports) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Room room(random_wall(seed));
    const EllipseFit fit = room.fit();
    ASSERT_TRUE(fit.found) << seed;
    EXPECT_NEAR(fit.taken, room.space->taken_by(fit.shape), 1e-9) << seed;
    const Circle circle = smallest_circle(room.hull);
    const Obstacle round{.p_MO = circle.p_MC, .a = circle.radius, .b = circle.radius};
    EXPECT_LE(fit.taken, room.space->taken_by(round) + 1e-6) << seed;
  }
}

TEST(EllipseFit, ABonusMakesTheCircleOfASquareTheChoice) {
  std::vector<CellIndex> square;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 8; ++k) square.push_back({56 + i, 56 + k});
  const Room room(square);
  FitLimits limits = kLoose;
  limits.circle_bonus = 1.0;
  const EllipseFit fit = room.fit(limits);
  EXPECT_EQ(fit.shape.a, fit.shape.b);
  EXPECT_NEAR(fit.shape.a, 0.2 * std::sqrt(2.0), 1e-6);
}

TEST(EllipseFit, AWallIsCoveredFlat) {
  std::vector<CellIndex> wall;
  for (int i = 0; i < 60; ++i) wall.push_back({30 + i, 60});
  const EllipseFit fit = Room(wall).fit();
  EXPECT_LT(fit.shape.b, 0.15);
  EXPECT_GT(fit.shape.a, 1.5);
  EXPECT_LT(fit.shape.a, 2.2);
  EXPECT_NEAR(std::sin(fit.shape.angle), 0.0, 0.05);
  EXPECT_NEAR(std::sin(fit.length_angle), 0.0, 1e-9);
}

TEST(EllipseFit, FindsNothingWhereNoShapeIsWithinTheLimits) {
  std::vector<CellIndex> wall;
  for (int i = 0; i < 60; ++i) wall.push_back({30 + i, 60});
  const Room room(wall);
  FitLimits dear = kLoose, shallow = kLoose;
  dear.price = -1.0;
  shallow.excess = {0.0, 0.0, 0.0};
  for (const FitLimits& limits : {dear, shallow}) {
    const EllipseFit fit = room.fit(limits);
    EXPECT_FALSE(fit.found);
    EXPECT_EQ(fit.shape.a, fit.shape.b) << "a circle";
  }
}

}  // namespace
}  // namespace tandem
