// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/dead_zone.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(DeadZone, IsRestAndBeyondItTheStickIsLinearToFullDeflection) {
  for (const double position : {0.0, 0.05, -0.1}) EXPECT_EQ(beyond_dead_zone(position, 0.1), 0.0);
  EXPECT_NEAR(beyond_dead_zone(0.55, 0.1), 0.5, 1e-12);
  EXPECT_NEAR(beyond_dead_zone(-0.55, 0.1), -0.5, 1e-12);
  EXPECT_EQ(beyond_dead_zone(1.0, 0.1), 1.0);
  EXPECT_EQ(beyond_dead_zone(-1.04, 0.1), -1.0);  // a device that exceeds its range
}

TEST(DeadZone, IsPassedByTheInverse) {
  for (const double dead_zone : {0.0, 0.05, 0.4})
    for (double deflection = -1.0; deflection <= 1.0; deflection += 0.125)
      EXPECT_NEAR(beyond_dead_zone(through_dead_zone(deflection, dead_zone), dead_zone), deflection,
                  1e-12)
          << dead_zone;
  EXPECT_EQ(through_dead_zone(0.0, 0.05), 0.0);
  EXPECT_LE(through_dead_zone(1.0, 0.05), 1.0);
}

}  // namespace
}  // namespace tandem
