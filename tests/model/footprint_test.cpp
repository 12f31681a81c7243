// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/footprint.hpp"
#include "model/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include "support/instrumented.hpp"
#include "support/level.hpp"

namespace tandem {
namespace {

using test::level;
using test::Random;
using test::samples;
using test::uniform;

// Convex outline around the origin: points on an ellipse in order of angle.
Footprint random_footprint(Random& random) {
  const int count = std::uniform_int_distribution<int>(3, 8)(random);
  const double a = uniform(random, 0.2, 0.8), b = uniform(random, 0.2, 0.5);
  std::vector<Eigen::Vector2d> p_BV;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + uniform(random, -0.2, 0.2)) / count;
    p_BV.emplace_back(a * std::cos(angle), b * std::sin(angle));
  }
  return polygon(std::move(p_BV));
}

double half_width(const Footprint& footprint) {
  double low = 0.0, high = 0.0;
  for (const auto& p : footprint.parts.front()) {
    low = std::min(low, p.y());
    high = std::max(high, p.y());
  }
  return 0.5 * (high - low);
}

Pose2 random_pose(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -4.0, 4.0)};
}

// Of a footprint of one part.
bool inside(const Footprint& footprint, const Eigen::Vector2d& p) {
  const ConvexPolygon& p_BV = footprint.parts.front();
  for (std::size_t i = 0; i < p_BV.size(); ++i) {
    const Eigen::Vector2d a = p_BV[i];
    const Eigen::Vector2d b = p_BV[(i + 1) % p_BV.size()];
    if ((b - a).x() * (p - a).y() - (b - a).y() * (p - a).x() < 0.0) return false;
  }
  return true;
}

// Outline and square as dense points: the distance from above, to within the spacing.
double sampled_distance(const Footprint& footprint, const Pose2& X_MB, const Eigen::Vector2d& p_MC,
                        double side, int per_edge) {
  double d = std::numeric_limits<double>::infinity();
  const ConvexPolygon& p_BV = footprint.parts.front();
  for (std::size_t i = 0; i < p_BV.size(); ++i)
    for (int k = 0; k < per_edge; ++k) {
      const double s = static_cast<double>(k) / per_edge;
      const Eigen::Vector2d p_BQ = (1.0 - s) * p_BV[i] + s * p_BV[(i + 1) % p_BV.size()];
      const Eigen::Vector2d q = transform(X_MB, p_BQ) - p_MC;
      const double dx = std::max(0.0, std::abs(q.x()) - 0.5 * side);
      const double dy = std::max(0.0, std::abs(q.y()) - 0.5 * side);
      d = std::min(d, std::hypot(dx, dy));
    }
  return inside(footprint, transform(inverse(X_MB), p_MC)) ? 0.0 : d;
}

TEST(Footprint, IsRefusedUnlessConvexCounterClockwiseAndAroundTheOrigin) {
  EXPECT_NO_THROW((void)polygon({{-1, -1}, {1, -1}, {0, 1}}));
  EXPECT_THROW((void)polygon({{-1, -1}, {1, -1}}), std::invalid_argument);
  EXPECT_THROW((void)polygon({{-1, -1}, {0, 1}, {1, -1}}), std::invalid_argument);  // clockwise
  EXPECT_THROW((void)polygon({{-1, -1}, {1, -1}, {0, -0.5}, {0, 1}}), std::invalid_argument);
  EXPECT_THROW((void)polygon({{1, 1}, {2, 1}, {1.5, 2}}), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)polygon({{-1, -1}, {1, nan}, {0, 1}}), std::invalid_argument);
}

TEST(Footprint, RectangleLiesAroundItsCentre) {
  const Footprint mir = rectangle(0.89, 0.58, 0.038);
  EXPECT_NEAR(circumradius(mir), std::hypot(0.483, 0.29), 1e-12);
  EXPECT_NEAR(distance(mir, {0.583, 0.0}), 0.1, 1e-12);
  EXPECT_NEAR(distance(mir, {-0.507, 0.0}), 0.1, 1e-12);
  EXPECT_NEAR(distance(mir, {0.483 + 0.3, 0.29 + 0.4}), 0.5, 1e-12);
  EXPECT_EQ(distance(mir, {0.4, -0.2}), 0.0);
}

TEST(Footprint, DistanceToAPointMatchesBruteForce) {
  Random random(1);
  for (unsigned i = 0; i < samples(2000, 200); ++i) {
    const Footprint footprint = random_footprint(random);
    const Eigen::Vector2d p{uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5)};
    const double sampled = sampled_distance(footprint, {}, p, 0.0, 400);
    EXPECT_LE(distance(footprint, p), sampled + 1e-12);
    EXPECT_GE(distance(footprint, p), sampled - 0.003);
  }
}

TEST(Footprint, DistanceToASquareMatchesBruteForce) {
  constexpr unsigned kSquares = samples(5000, 500);
  Random random(2);
  unsigned touching = 0, apart = 0;
  for (unsigned i = 0; i < kSquares; ++i) {
    const Footprint footprint = random_footprint(random);
    const Pose2 X_MB = random_pose(random, 1.0);
    const Eigen::Vector2d p_MC{uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0)};
    const double side = uniform(random, 0.02, 0.6);
    const double exact = distance_to_square(footprint, X_MB, p_MC, side);
    const double sampled = sampled_distance(footprint, X_MB, p_MC, side, 400);
    EXPECT_LE(exact, sampled + 1e-12);
    EXPECT_GE(exact, sampled - 0.004);  // spacing of the samples, at a corner of the square
    (exact == 0.0 ? touching : apart)++;
  }
  EXPECT_GT(touching, kSquares / 10);
  EXPECT_GT(apart, kSquares / 5);
}

TEST(Footprint, TouchesASquareWhollyInsideItAndASquareAroundIt) {
  const Footprint mir = rectangle(0.89, 0.58, 0.038);
  EXPECT_EQ(distance_to_square(mir, {1.0, 2.0, 0.7}, {1.05, 2.0}, 0.05), 0.0);
  EXPECT_EQ(distance_to_square(mir, {1.0, 2.0, 0.7}, {1.0, 2.0}, 5.0), 0.0);
}

TEST(Footprint, OverlapWithAnObstacleMatchesBruteForce) {
  constexpr unsigned kObstacles = samples(3000, 300);
  Random random(3);
  unsigned overlapping = 0;
  for (unsigned i = 0; i < kObstacles; ++i) {
    const Footprint footprint = random_footprint(random);
    const Pose2 X_MB = random_pose(random, 1.0);
    Obstacle obstacle;
    obstacle.p_MO = {uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0)};
    obstacle.a = uniform(random, 0.1, 0.8);
    obstacle.b = uniform(random, 0.05, 1.0) * obstacle.a;
    obstacle.angle = uniform(random, -4.0, 4.0);
    if (i % 2 == 1) obstacle.shape = ObstacleShape::kRectangle;
    // The level is convex along an edge; its minimum over the outline decides, within the spacing.
    double least = inside(footprint, transform(inverse(X_MB), obstacle.p_MO))
                       ? 0.0
                       : std::numeric_limits<double>::infinity();
    const ConvexPolygon& p_BV = footprint.parts.front();
    for (std::size_t v = 0; v < p_BV.size(); ++v)
      for (int k = 0; k < 300; ++k) {
        const double s = k / 300.0;
        const Eigen::Vector2d p = (1.0 - s) * p_BV[v] + s * p_BV[(v + 1) % p_BV.size()];
        least = std::min(least, level(obstacle, transform(X_MB, p)));
      }
    if (least < 1.0) {
      EXPECT_TRUE(overlaps(footprint, X_MB, obstacle));
      ++overlapping;
    } else if (least > 1.0 + 0.2 * obstacle.a / obstacle.b) {
      EXPECT_FALSE(overlaps(footprint, X_MB, obstacle));
    }
  }
  EXPECT_GT(overlapping, kObstacles / 6);
  EXPECT_LT(overlapping, kObstacles * 5 / 6);
}

TEST(Footprint, IsAsWideAsItsPartsAreAcrossTheDirectionOfTravel) {
  EXPECT_NEAR(width(rectangle(1.0, 0.65, 0.2)), 0.65, 1e-12);
  EXPECT_NEAR(width(polygon({{-0.2, -0.1}, {0.5, -0.3}, {0.1, 0.4}})), 0.7, 1e-12);
  EXPECT_NEAR(width(polygons({{{-0.5, -0.1}, {0.5, -0.1}, {0.5, 0.1}, {-0.5, 0.1}},
                              {{0.4, 0.3}, {0.6, 0.3}, {0.6, 0.5}}})),
              0.6, 1e-12);
}

TEST(Footprint, IsCoveredByAsManyDiscsAsTheOverhangAsksFor) {
  const Footprint wheelchair = rectangle(1.0, 0.65, 0.2);
  for (const auto& [overhang, count] : {std::pair{0.014, 6}, {0.016, 5}, {0.04, 4}, {1.0, 1}})
    EXPECT_EQ(cover_by_discs(wheelchair, overhang).size(), static_cast<std::size_t>(count))
        << overhang;
}

TEST(Footprint, IsContainedInTheDiscsThatCoverIt) {
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    const Footprint footprint = random_footprint(random);
    std::size_t fewest = 0;
    for (const double overhang : {2.0, 0.1, 0.03, 0.01}) {
      const auto discs = cover_by_discs(footprint, overhang);
      EXPECT_GE(discs.size(), fewest);
      fewest = discs.size();
      for (const Disc& disc : discs)
        EXPECT_LE(disc.radius, half_width(footprint) + overhang + 1e-9);
      for (int k = 0; k < 50; ++k) {
        const Eigen::Vector2d p{uniform(random, -0.8, 0.8), uniform(random, -0.5, 0.5)};
        if (!inside(footprint, p)) continue;
        EXPECT_TRUE(std::any_of(discs.begin(), discs.end(), [&](const Disc& disc) {
          return (p - disc.p_BC).norm() <= disc.radius + 1e-12;
        }));
      }
    }
  }
}

}  // namespace
}  // namespace tandem
