// SPDX-License-Identifier: Apache-2.0
#include "tandem/obstacle_extractor/cover/cover_part.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "obstacle_extractor/cover/room.hpp"

namespace tandem::test {
namespace {

constexpr double kAnyCost = 100.0;
constexpr CoverParams kLimits{.excess = {0.3, 0.1, 0.05}, .space_per_shape = 0.1, .crowded = 100};

TEST(PartFitter, AFitContainsEachOfItsCells) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const auto cells = random_wall(seed);
    const Room room(cells);
    const PartFitter fitter(room.map->grid(), *room.space, kLimits);
    const CoverPart part = fitter.fit(cells, kAnyCost);
    for (const CellIndex& cell : cells) ASSERT_TRUE(fitter.contains(part, cell)) << seed;
    EXPECT_FALSE(fitter.contains(part, {5, 5})) << seed;
  }
}

TEST(PartFitter, TheFitOfTwoPartsIsThatOfTheirCellsTogether) {
  const Cells left = block(40, 60, 12, 3), right = block(56, 58, 8, 4);
  const Room room(joined(left, right));
  const PartFitter fitter(room.map->grid(), *room.space, kLimits);
  const CoverPart p = fitter.fit(left, kAnyCost), q = fitter.fit(right, kAnyCost);
  const CoverPart both = fitter.fit_both(p, q, kAnyCost);
  const CoverPart all = fitter.fit(joined(left, right), kAnyCost);
  EXPECT_TRUE(both.cells.empty());
  EXPECT_NEAR(both.fit.taken, all.fit.taken, 1e-9);
  EXPECT_NEAR((both.fit.shape.p_MO - all.fit.shape.p_MO).norm(), 0.0, 1e-9);
  EXPECT_EQ(both.outline->low, all.outline->low);
  EXPECT_EQ(both.outline->high, all.outline->high);
}

TEST(PartFitter, ACircleCostsLessThanAnotherShapeThatTakesAsMuch) {
  const Room room(block(60, 60, 1, 1));
  const PartFitter fitter(room.map->grid(), *room.space, kLimits);
  CoverPart part = fitter.fit(block(60, 60, 1, 1), kAnyCost);
  ASSERT_TRUE(is_circle(part.fit.shape));
  EXPECT_NEAR(fitter.cost(part), PartFitter::kLeastCost + part.fit.taken / 0.1, 1e-12);
  part.fit.shape.a += 0.01;
  EXPECT_NEAR(fitter.cost(part), 1.0 + part.fit.taken / 0.1, 1e-12);
  part.fit.shape.a -= 0.01;
  part.fit.shape.shape = ObstacleShape::kRectangle;
  EXPECT_NEAR(fitter.cost(part), 1.0 + part.fit.taken / 0.1, 1e-12);
}

TEST(PartFitter, WhenCoarserTheSameShapeCostsLess) {
  const Cells corner = joined(block(50, 50, 20, 2), block(50, 52, 2, 6));
  const Room room(corner);
  PartFitter fitter(room.map->grid(), *room.space, kLimits);
  const CoverPart part = fitter.fit(corner, kAnyCost);
  ASSERT_GT(part.fit.taken, 0.0);
  const double before = fitter.cost(part);
  fitter.coarsen();
  EXPECT_LT(fitter.cost(part), before);
}

TEST(PartFitter, FindsNoShapeThatWouldCostTooMuch) {
  const Cells corner = joined(block(50, 50, 20, 2), block(50, 52, 2, 18));
  const Room room(corner);
  const PartFitter fitter(room.map->grid(), *room.space, kLimits);
  EXPECT_FALSE(fitter.fit(corner, 1.1).fit.found);
  EXPECT_TRUE(fitter.fit(block(50, 50, 20, 2), kAnyCost).fit.found);
}

// A fitter keeps what it has computed of a hull; another one that has seen nothing finds the same.
TEST(PartFitter, WhatItHasFittedBeforeChangesNoFit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> cost(0.5, 4.0);
  int found = 0, vain = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const auto cells = random_wall(seed);
    const Room room(cells);
    const PartFitter fitter(room.map->grid(), *room.space, kLimits);
    for (int i = 0; i < 12; ++i) {
      const double most = cost(random);
      const PartFitter fresh(room.map->grid(), *room.space, kLimits);
      const CoverPart known = fitter.fit(cells, most), part = fresh.fit(cells, most);
      ASSERT_EQ(known.fit.found, part.fit.found) << seed << ", at most " << most;
      ++(part.fit.found ? found : vain);
      if (!part.fit.found) continue;
      EXPECT_EQ(known.fit.taken, part.fit.taken);
      EXPECT_EQ(known.fit.shape.p_MO, part.fit.shape.p_MO);
      EXPECT_EQ(known.fit.shape.a, part.fit.shape.a);
      EXPECT_EQ(known.fit.shape.b, part.fit.shape.b);
      EXPECT_LE(known.least, fitter.cost(known) + 1e-9);
    }
  }
  EXPECT_GT(found, 50);
  EXPECT_GT(vain, 50);
}

TEST(PartFitter, NoFitCostsLessThanItsOutlineMust) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const auto cells = random_wall(seed);
    const Room room(cells);
    const PartFitter fitter(room.map->grid(), *room.space, kLimits);
    const double least = fitter.outline(cells, kAnyCost).least;
    const CoverPart part = fitter.fit(cells, kAnyCost);
    ASSERT_TRUE(part.fit.found) << seed;
    EXPECT_LE(least, fitter.cost(part)) << seed;
    EXPECT_GE(least, PartFitter::kLeastCost) << seed;
    const bool is_found = fitter.fit(cells, fitter.cost(part) + 1e-6).fit.found;
    EXPECT_TRUE(is_found) << seed << ": the bound hides a shape";
  }
}

TEST(PartFitter, CutsAtAFractionOfTheExtentAcrossTheGivenAngle) {
  const Room room(block(40, 40, 20, 6));
  const PartFitter fitter(room.map->grid(), *room.space, kLimits);
  Cells cells = block(40, 40, 20, 6);
  auto middle = fitter.cut(cells, 0.0, 0.25);
  EXPECT_TRUE(std::all_of(cells.begin(), middle, [](auto& cell) { return cell.ix <= 44; }));
  EXPECT_TRUE(std::all_of(middle, cells.end(), [](auto& cell) { return cell.ix > 44; }));
  middle = fitter.cut(cells, 0.5 * std::numbers::pi, 0.5);
  EXPECT_TRUE(std::all_of(cells.begin(), middle, [](auto& cell) { return cell.iy <= 42; }));
  EXPECT_TRUE(std::all_of(middle, cells.end(), [](auto& cell) { return cell.iy > 42; }));
}

TEST(PartFitter, ACutLeavesNeitherSideEmpty) {
  const Room room(block(40, 40, 2, 1));
  const PartFitter fitter(room.map->grid(), *room.space, kLimits);
  for (const double angle : {0.0, 0.8, 0.5 * std::numbers::pi, 2.4})
    for (const double fraction : {0.0, 0.25, 0.5, 1.0}) {
      Cells cells = block(40, 40, 2, 1);
      const auto middle = fitter.cut(cells, angle, fraction);
      EXPECT_NE(middle, cells.begin()) << angle << ' ' << fraction;
      EXPECT_NE(middle, cells.end()) << angle << ' ' << fraction;
    }
}

TEST(PartFitter, NeighboursAreAtMostTheLongestGapApart) {
  const Room room(block(20, 60, 2, 2));
  const PartFitter fitter(room.map->grid(), *room.space, kLimits);
  const CoverPart part = fitter.fit(block(20, 60, 2, 2), kAnyCost);
  EXPECT_TRUE(PartFitter::neighbours(part, fitter.fit(block(37, 60, 2, 2), kAnyCost)));   // 0.75 m
  EXPECT_FALSE(PartFitter::neighbours(part, fitter.fit(block(39, 60, 2, 2), kAnyCost)));  // 0.85 m
}

TEST(PartFitter, AShapeIsNamedAfterItsLowestCellAndBoundsItsCells) {
  const Cells cells{{31, 42}, {30, 41}, {30, 42}};
  const Room room(cells);
  const PartFitter fitter(room.map->grid(), *room.space, kLimits);
  const CoverShape shape = fitter.shape(fitter.fit(cells, kAnyCost));
  EXPECT_EQ(shape.obstacle.id, 41U * Room::kCells + 30U + 1U);
  EXPECT_NEAR((shape.low - Eigen::Vector2d(1.50, 2.05)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((shape.high - Eigen::Vector2d(1.60, 2.15)).norm(), 0.0, 1e-9);
}

}  // namespace
}  // namespace tandem::test
