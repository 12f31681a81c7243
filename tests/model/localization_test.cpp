// SPDX-License-Identifier: Apache-2.0
#include "tandem/model/localization.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(Localization, ComposesFreshPartsOnly) {
  Localization localization{{}};
  EXPECT_FALSE(localization.state(0.0));
  localization.on_odom({1.0, 0.0, 0.0}, {0.2, 0.0}, 0.0);
  EXPECT_FALSE(localization.state(0.0));
  localization.on_transform({0.0, 2.0, 0.0}, 0.0);
  ASSERT_TRUE(localization.state(0.1));
  EXPECT_EQ(localization.state(0.1)->X_MB, (Pose2{1.0, 2.0, 0.0}));
  EXPECT_FALSE(localization.state(0.2));  // odom_timeout
  localization.on_odom({1.0, 0.0, 0.0}, {0.2, 0.0}, 1.1);
  EXPECT_FALSE(localization.state(1.1));  // transform_timeout
}

// static_transform_publisher publishes map → odom once.
TEST(Localization, AStaticTransformHoldsForeverUntilALocaliserPublishes) {
  Localization localization{{}};
  localization.on_static_transform({0.0, 2.0, 0.0});
  localization.on_odom({1.0, 0.0, 0.0}, {}, 100.0);
  ASSERT_TRUE(localization.state(100.0));
  EXPECT_EQ(localization.state(100.0)->X_MB, (Pose2{1.0, 2.0, 0.0}));
  localization.on_transform({0.0, 5.0, 0.0}, 100.0);
  EXPECT_EQ(localization.state(100.0)->X_MB, (Pose2{1.0, 5.0, 0.0}));
  localization.on_static_transform({0.0, 2.0, 0.0});
  EXPECT_EQ(localization.state(100.0)->X_MB, (Pose2{1.0, 5.0, 0.0}));
  localization.on_odom({1.0, 0.0, 0.0}, {}, 102.0);
  EXPECT_FALSE(localization.state(102.0));  // a missing transform counts then
}

TEST(Localization, ATransformIsAsOldAsTheOldestPartOfIt) {
  Localization localization{{}};
  localization.on_odom({1.0, 0.0, 0.0}, {}, 10.0);
  localization.on_transform({0.0, 2.0, 0.0}, 10.0, 0.9);
  EXPECT_TRUE(localization.state(10.05));
  localization.on_odom({1.0, 0.0, 0.0}, {}, 10.15);
  EXPECT_FALSE(localization.state(10.15));
}

}  // namespace
}  // namespace tandem
