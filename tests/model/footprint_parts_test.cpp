// SPDX-License-Identifier: Apache-2.0
// Tests outlines of several convex parts, and which outlines are rejected.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "model/random.hpp"
#include "support/instrumented.hpp"
#include "support/level.hpp"
#include "tandem/model/footprint.hpp"

namespace tandem {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using test::Random;
using test::samples;
using test::uniform;

// One shape in two forms: the parts under test, and its true outline, which is not convex.
struct Shape {
  Footprint footprint;
  Points outline;
};

// Forks in front of a body; the parts overlap.
Shape u_shape() {
  return {polygons({{{-0.4, -0.4}, {0.2, -0.4}, {0.2, 0.4}, {-0.4, 0.4}},
                    {{0.1, -0.4}, {0.9, -0.4}, {0.9, -0.25}, {0.1, -0.25}},
                    {{0.1, 0.25}, {0.7, 0.25}, {0.7, 0.4}, {0.1, 0.4}}}),
          {{-0.4, -0.4},
           {0.9, -0.4},
           {0.9, -0.25},
           {0.2, -0.25},
           {0.2, 0.25},
           {0.7, 0.25},
           {0.7, 0.4},
           {-0.4, 0.4}}};
}

// The parts share an edge.
Shape l_shape() {
  return {polygons({{{0.2, 0.1}, {0.5, 0.1}, {0.5, 0.7}, {0.2, 0.7}},
                    {{-0.6, -0.2}, {0.5, -0.2}, {0.5, 0.1}, {-0.6, 0.1}}}),
          {{-0.6, -0.2}, {0.5, -0.2}, {0.5, 0.7}, {0.2, 0.7}, {0.2, 0.1}, {-0.6, 0.1}}};
}

// Counts the edges that a ray to the right crosses.
bool inside(const Points& outline, const Eigen::Vector2d& p) {
  bool is_inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) is_inside = !is_inside;
  }
  return is_inside;
}

constexpr double kSpacing = 0.005;  // [m] between samples

// Samples the area on a grid, and the outline along its length.
Points samples_of(const Points& outline) {
  Points points;
  for (double x = -1.0; x < 1.0; x += kSpacing)
    for (double y = -1.0; y < 1.0; y += kSpacing)
      if (inside(outline, {x, y})) points.emplace_back(x, y);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d a = outline[i], ab = outline[(i + 1) % outline.size()] - a;
    for (double s = 0.0; s <= 1.0; s += kSpacing / ab.norm()) points.emplace_back(a + s * ab);
  }
  return points;
}

double square_distance(const Eigen::Vector2d& p, double half) {
  return std::hypot(std::max(0.0, std::abs(p.x()) - half), std::max(0.0, std::abs(p.y()) - half));
}

class PartsAgainstSamples : public testing::TestWithParam<Shape (*)()> {
 protected:
  const Shape shape_ = GetParam()();
  const Points samples_ = samples_of(shape_.outline);
  Random random_{11};

  Eigen::Vector2d anywhere() { return {uniform(random_, -1.5, 1.5), uniform(random_, -1.5, 1.5)}; }

  // Least value of `measure(point)` over the sampled shape at X_MB.
  template <class Measure>
  double least(const Pose2& X_MB, const Measure& measure) const {
    double value = std::numeric_limits<double>::infinity();
    for (const auto& p_BQ : samples_) value = std::min(value, measure(transform(X_MB, p_BQ)));
    return value;
  }
};

TEST_P(PartsAgainstSamples, DistanceToAPoint) {
  for (unsigned i = 0; i < samples(150, 50); ++i) {
    const Eigen::Vector2d p = anywhere();
    const double exact = distance(shape_.footprint, p);
    const double sampled = least({}, [&](const auto& q) { return (q - p).norm(); });
    EXPECT_LE(exact, sampled + 1e-12);
    EXPECT_GE(exact, sampled - kSpacing);
    EXPECT_EQ(exact == 0.0, inside(shape_.outline, p)) << p.transpose();
  }
}

TEST_P(PartsAgainstSamples, DistanceToASquare) {
  unsigned apart = 0;
  for (unsigned i = 0; i < samples(150, 50); ++i) {
    const Pose2 X_MB{uniform(random_, -1, 1), uniform(random_, -1, 1), uniform(random_, -4, 4)};
    const Eigen::Vector2d p_MC = anywhere();
    const double side = uniform(random_, 0.02, 0.4);
    const double exact = distance_to_square(shape_.footprint, X_MB, p_MC, side);
    const double sampled =
        least(X_MB, [&](const auto& q) { return square_distance(q - p_MC, 0.5 * side); });
    EXPECT_LE(exact, sampled + 1e-12);
    EXPECT_GE(exact, sampled - kSpacing);
    apart += exact > 0.0 ? 1 : 0;
  }
  EXPECT_GT(apart, samples(50, 15));
}

TEST_P(PartsAgainstSamples, OverlapWithAnObstacle) {
  constexpr unsigned kObstacles = samples(300, 100);
  unsigned overlapping = 0, apart = 0;
  for (unsigned i = 0; i < kObstacles; ++i) {
    const Pose2 X_MB{uniform(random_, -1, 1), uniform(random_, -1, 1), uniform(random_, -4, 4)};
    Obstacle obstacle;
    obstacle.p_MO = anywhere();
    obstacle.a = uniform(random_, 0.1, 0.5);
    obstacle.b = uniform(random_, 0.3, 1.0) * obstacle.a;
    obstacle.angle = uniform(random_, -4.0, 4.0);
    if (i % 2 == 1) obstacle.shape = ObstacleShape::kRectangle;
    const double nearest = least(X_MB, [&](const auto& q) { return test::level(obstacle, q); });
    if (nearest < 1.0) {
      EXPECT_TRUE(overlaps(shape_.footprint, X_MB, obstacle));
      ++overlapping;
    } else if (nearest > 1.2) {
      EXPECT_FALSE(overlaps(shape_.footprint, X_MB, obstacle));
      ++apart;
    }
  }
  EXPECT_GT(overlapping, kObstacles / 6);
  EXPECT_GT(apart, kObstacles / 6);
}

TEST_P(PartsAgainstSamples, CircumradiusAndDiscsHoldTheWholeShape) {
  const double radius = circumradius(shape_.footprint);
  const auto discs = cover_by_discs(shape_.footprint, 0.04);
  for (const auto& p : samples_) {
    EXPECT_LE(p.norm(), radius + 1e-12);
    EXPECT_TRUE(std::any_of(discs.begin(), discs.end(), [&](const Disc& disc) {
      return (p - disc.p_BC).norm() <= disc.radius + 1e-12;
    })) << p.transpose();
  }
}

TEST_P(PartsAgainstSamples, InsetStaysWithinItself) {
  for (const double depth : {0.005, 0.03, 0.2})
    for (const auto& part : inset(shape_.footprint, depth).parts)
      for (std::size_t i = 0; i < part.size(); ++i)
        for (double s = 0.0; s < 1.0; s += 0.02) {
          const Eigen::Vector2d p = (1.0 - s) * part[i] + s * part[(i + 1) % part.size()];
          EXPECT_TRUE(inside(shape_.outline, p)) << depth << ": " << p.transpose();
        }
}

INSTANTIATE_TEST_SUITE_P(Shapes, PartsAgainstSamples, testing::Values(&u_shape, &l_shape));

TEST(FootprintParts, APoleBetweenTheForksIsNoContactThoughTheHullContainsIt) {
  const Footprint robot = u_shape().footprint;
  Obstacle pole;
  pole.p_MO = {0.5, 0.0};
  pole.a = pole.b = 0.1;
  EXPECT_FALSE(overlaps(robot, {}, pole));
  EXPECT_NEAR(distance(robot, pole.p_MO), 0.25, 1e-12);
  EXPECT_NEAR(distance_to_square(robot, {}, pole.p_MO, 0.1), 0.2, 1e-12);

  const Footprint hull = polygon({{-0.4, -0.4}, {0.9, -0.4}, {0.9, 0.4}, {-0.4, 0.4}});
  EXPECT_TRUE(overlaps(hull, {}, pole));
  EXPECT_EQ(distance(hull, pole.p_MO), 0.0);
}

TEST(FootprintParts, DiscsLeaveTheSpaceBetweenTheForksFree) {
  const Footprint robot = u_shape().footprint;
  for (const Disc& disc : cover_by_discs(robot, 0.04))
    EXPECT_GT((disc.p_BC - Eigen::Vector2d(0.55, 0.0)).norm(), disc.radius + 0.15);
}

TEST(FootprintParts, InsetMovesEveryEdgeInwards) {
  const Footprint smaller = inset(rectangle(0.8, 0.4, 0.1), 0.05);
  ASSERT_EQ(smaller.parts.size(), 1u);
  EXPECT_NEAR(distance(smaller, {0.1, 0.2}), 0.05, 1e-12);
  EXPECT_NEAR(distance(smaller, {0.5, 0.0}), 0.05, 1e-12);
  EXPECT_NEAR(distance(smaller, {-0.3, 0.0}), 0.05, 1e-12);
  EXPECT_TRUE(inset(rectangle(0.8, 0.4, 0.1), 0.21).parts.empty());
}

// --- what is refused, and where the message says the fault is
// ---------------------------------------

// The error message for these parts, without "footprint: "; empty if they are accepted.
std::string complaint(std::vector<ConvexPolygon> parts) {
  try {
    (void)polygons(std::move(parts));
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_TRUE(text.starts_with("footprint: ")) << text;
    return text.substr(std::string("footprint: ").size());
  }
  return "";
}

const ConvexPolygon kBody{{-0.4, -0.3}, {0.4, -0.3}, {0.4, 0.3}, {-0.4, 0.3}};

void expect_refused(const ConvexPolygon& second, const std::string& place,
                    const std::string& reason) {
  const std::string text = complaint({kBody, second});
  EXPECT_TRUE(text.starts_with(place)) << text;
  EXPECT_NE(text.find(reason), std::string::npos) << text;
}

TEST(RefusedFootprint, IsAPentagramThoughAllItsTurnsAreLeft) {
  ConvexPolygon star;
  for (int i = 0; i < 5; ++i) star.emplace_back(std::cos(2.4 * i), std::sin(2.4 * i));
  star[3] = {-0.3, 0.9};  // not symmetric, as if typed by hand
  EXPECT_EQ(complaint({kBody, {{0, 0}, {1, 0}, {0, 1}}}), "");
  expect_refused(star, "part 2, vertex ", "crosses itself; list each vertex once");
  EXPECT_TRUE(complaint({star}).starts_with("part 1, vertex "));
}

TEST(RefusedFootprint, IsABowTie) {
  expect_refused({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, "part 2, vertex 2 at (1, 1): ", "turns right");
}

TEST(RefusedFootprint, IsOneThatRunsClockwise) {
  expect_refused({{0, 0}, {0, 1}, {1, 1}, {1, 0}},
                 "part 2, vertex 1 at (0, 0): ", "list the vertices counter-clockwise");
}

TEST(RefusedFootprint, HasADent) {
  expect_refused({{0, 0}, {1, 0}, {0.3, 0.3}, {0, 1}},
                 "part 2, vertex 3 at (0.3, 0.3): ", "split a concave outline into convex parts");
}

TEST(RefusedFootprint, RepeatsAVertex) {
  expect_refused({{0, 0}, {1, 0}, {1, 0}, {0, 1}}, "part 2, vertex 3 at (1, 0): ", "repeats");
  expect_refused({{0, 0}, {1, 0}, {0, 1}, {0, 0}}, "part 2, vertex 1 at (0, 0): ", "repeats");
}

TEST(RefusedFootprint, HasAVertexOnAnEdge) {
  expect_refused({{0, 0}, {1, 0}, {2, 0}, {0, 1}}, "part 2, vertex 2 at (1, 0): ", "collinear");
  expect_refused({{0, 0}, {2, 0}, {1, 0}}, "part 2, vertex 1 at (0, 0): ", "collinear");
}

TEST(RefusedFootprint, HasTwoVertices) {
  expect_refused({{0, 0}, {1, 0}}, "part 2: ", "has 2 vertices; a polygon needs at least 3");
  EXPECT_EQ(complaint({}), "has no parts");
}

TEST(RefusedFootprint, HasACoordinateThatIsNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused({{0, 0}, {1, 0}, {nan, 1}}, "part 2, vertex 3 at (nan, 1): ", "finite");
  const double huge = 1e300;  // finite, but overflows in arithmetic
  EXPECT_NE(complaint({kBody, {{0, 0}, {huge, -huge}, {huge, huge}}}), "");
}

TEST(RefusedFootprint, LeavesTheOriginOutside) {
  const std::string text = complaint(
      {{{2.0, 0.0}, {3.0, 0.0}, {2.5, 1.0}}, {{0.5, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {0.5, 1.0}}});
  EXPECT_EQ(text,
            "no part contains (0, 0), the origin of base_link; the nearest, part 2, is 0.5 m away. "
            "Give the vertices in the frame base_link; one part must contain its origin");
}

}  // namespace
}  // namespace tandem
