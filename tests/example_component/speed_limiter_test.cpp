// SPDX-License-Identifier: Apache-2.0
#include "speed_limiter.hpp"

#include <gtest/gtest.h>

namespace example {
namespace {

TEST(SpeedLimiter, PassesWhatIsWithinTheLimits) { EXPECT_EQ(factor_for({0.3, -0.5}, {}), 1.0); }

TEST(SpeedLimiter, ScalesSpeedAndTurnRateByTheSameFactor) {
  EXPECT_DOUBLE_EQ(factor_for({-2.0, 0.4}, {.max_speed = 0.5}), 0.25);
  EXPECT_DOUBLE_EQ(factor_for({0.1, 1.6}, {.max_turn_rate = 0.8}), 0.5);
}

}  // namespace
}  // namespace example
