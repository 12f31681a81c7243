// SPDX-License-Identifier: Apache-2.0
// Compares what is found near the body with all pairs of discs and obstacles.
#include "tandem/local_planner/ocp/pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tandem/local_planner/ocp/signed_distance.hpp"

namespace tandem {
namespace {

constexpr PairLimits kFourNearest{
    .margin = 0.05, .moving = 0.3, .start = 0.1, .dt = 0.25, .reach = 0.8, .max_pairs = 4};

// The clearances of all pairs at a pose, ascending.
std::vector<double> all_clearances(const Body& body, const std::vector<Obstacle>& obstacles,
                                   const Pose2& X_MB, double t) {
  std::vector<double> all;
  for (const Obstacle& obstacle : obstacles)
    for (const Disc& disc : body.discs) {
      const double margin =
          kFourNearest.margin + (obstacle.v_MO.norm() > 0.05 ? kFourNearest.moving : 0.0);
      const auto phi = signed_distance(predicted(obstacle, t), transform(X_MB, disc.p_BC));
      all.push_back(phi.value - disc.radius - margin);
    }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(Pairs, AreTheNearestOfAll) {
  std::mt19937 random{4};
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution{low, high}(random);
  };
  const Body body{{}, {{{-0.3, 0.0}, 0.3}, {{0.0, 0.1}, 0.25}, {{0.4, 0.0}, 0.2}}};
  for (int n = 0; n < 2000; ++n) {
    std::vector<Obstacle> obstacles;
    for (int j = 0; j < 8; ++j) {
      const double a = uniform(0.05, 1.0);
      obstacles.push_back({.p_MO = {uniform(-3, 3), uniform(-3, 3)},
                           .a = a,
                           .b = j % 2 == 0 ? a : uniform(0.02, a),
                           .angle = uniform(-3, 3)});
      if (j % 3 == 0) obstacles.back().v_MO = {uniform(-1, 1), uniform(-1, 1)};
    }
    const std::vector<Pose2> poses{{uniform(-1, 1), uniform(-1, 1), uniform(-3, 3)}};
    const double t = kFourNearest.start + kFourNearest.dt;
    const auto expected = all_clearances(body, obstacles, poses[0], t);
    const double least = std::min(expected.front(), kFourNearest.reach);
    EXPECT_NEAR(clearances(body, obstacles, poses, kFourNearest)[0], least, 1e-9) << n;
    EXPECT_EQ(first_miss(body, obstacles, poses, kFourNearest), least < 0.0 ? 0U : 1U) << n;
    const auto nearest = nearest_pairs(body, obstacles, poses, kFourNearest)[0];
    std::size_t within = 0;
    while (within < 4 && expected[within] < kFourNearest.reach) ++within;
    ASSERT_EQ(nearest.size(), within) << n;
    for (std::size_t i = 0; i < within; ++i)
      EXPECT_NEAR(clearance(nearest[i], poses[0]), expected[i], 1e-9) << n;
  }
}

}  // namespace
}  // namespace tandem
