// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/pair_batch.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tandem {
namespace {

class PairsAtRandom {
 public:
  Pair pair(bool round) {
    const double b = 0.05 + 0.3 * std::abs(unit());
    const double a = round || unit() > 0.5 ? b : b * (1.0 + 30.0 * std::abs(unit()));
    Obstacle obstacle{1, {3.0 * unit(), 3.0 * unit()}, a, b, 4.0 * unit(), {0, 0}};
    if (!round && unit() > 0.0) obstacle.shape = ObstacleShape::kRectangle;
    return {{unit(), unit()}, 0.3, obstacle, 0};
  }
  Placed place() { return Placed{{unit(), unit(), 4.0 * unit()}}; }

 private:
  double unit() { return unit_(random_); }

  std::mt19937 random_{1};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

TEST(PairBatch, GiveTheTermsOfEachPairWhereItsStageEnds) {
  PairsAtRandom random;
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Placed> X{random.place(), random.place()};
    const std::size_t count = 1 + static_cast<std::size_t>(i) % PairBatch::kLanes;
    PairBatch lanes;
    std::vector<PairTerms> expected;
    PairTable got;
    got.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      ASSERT_TRUE(lanes.has_room());
      const Pair pair = random.pair(i % 3 == 0);
      const std::size_t stage = k < count / 2 ? 0 : 1;
      lanes.add(pair, stage);
      expected.push_back(pair_terms(pair, X[stage]));
    }
    EXPECT_EQ(lanes.has_room(), count < PairBatch::kLanes);
    lanes.terms(X, 0, got);
    for (std::size_t k = 0; k < count; ++k) {
      EXPECT_NEAR(got[k].value, expected[k].value, 1e-12);
      EXPECT_LT((got[k].gradient() - expected[k].gradient()).norm(), 1e-7);
      EXPECT_NEAR(got[k].lean, expected[k].lean, 1e-7);
      EXPECT_NEAR(got[k].curvature, expected[k].curvature, 1e-5 * expected[k].curvature);
    }
  }
}

}  // namespace
}  // namespace tandem
