// SPDX-License-Identifier: Apache-2.0
#include "local_planner/reference.hpp"

#include <gtest/gtest.h>

namespace tandem::test {
namespace {

// Followed from its start, a straight trail of 3 m.
std::vector<StageCost> costs_along(double direction, const NmpcParams& params) {
  std::vector<Eigen::Vector2d> trail;
  const Eigen::Vector2d ahead{std::cos(direction), std::sin(direction)};
  for (int i = 0; i <= 60; ++i) trail.push_back(0.05 * i * ahead);
  const PlanRequest request{.method = Method::kPath,
                            .X_MG = {3.0 * ahead.x(), 3.0 * ahead.y(), direction},
                            .trail = trail};
  const RobotParams robot;
  const Forecast wish = forecast(request, {{0.0, 0.0, direction}, {}}, params, robot);
  return stage_costs(request, wish, params, robot);
}

// Of the position alone.
double cost_at(const StageCost& cost, const Eigen::Vector2d& off) {
  return off.dot(cost.pull(off));
}

TEST(PathCost, WeighsErrorsAcrossAndAlongTheTrailByTheirOwnWeights) {
  NmpcParams params;
  params.weight_across = 7.0;
  params.weight_along = 2.0;
  for (const double direction : {0.0, 0.7, 1.5708, -2.5})
    for (const StageCost& cost : costs_along(direction, params)) {
      const Eigen::Vector2d along{std::cos(direction), std::sin(direction)};
      const Eigen::Vector2d across{-along.y(), along.x()};
      EXPECT_NEAR(cost_at(cost, 0.3 * along), 2.0 * 0.09, 1e-9) << direction;
      EXPECT_NEAR(cost_at(cost, 0.3 * across), 7.0 * 0.09, 1e-9) << direction;
      EXPECT_NEAR(cost_at(cost, 0.3 * (along + across)), 9.0 * 0.09, 1e-9) << direction;
    }
}

TEST(PathCost, IsTheSameInEveryFrameWhereTheWeightsAreEqual) {
  NmpcParams params;
  params.weight_across = params.weight_along = 5.0;
  for (const StageCost& cost : costs_along(0.7, params)) {
    EXPECT_NEAR(cost.q_x, 5.0, 1e-12);
    EXPECT_NEAR(cost.q_y, 5.0, 1e-12);
    EXPECT_NEAR(cost.q_xy, 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace tandem::test
