// SPDX-License-Identifier: Apache-2.0
#include "speed_limiter.hpp"

#include <gtest/gtest.h>

namespace example {
namespace {

TEST(SpeedLimiter, PassesWhatIsWithinTheLimits) {
  const auto out = limited({0.3, -0.5}, {});
  EXPECT_EQ(out.v, 0.3);
  EXPECT_EQ(out.w, -0.5);
}

TEST(SpeedLimiter, KeepsTheCurvatureOfWhatItLimits) {
  const auto out = limited({-2.0, 0.4}, {.max_speed = 0.5});
  EXPECT_EQ(out.v, -0.5);
  EXPECT_DOUBLE_EQ(out.w, 0.1);
}

}  // namespace
}  // namespace example
