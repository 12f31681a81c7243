// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/driver_lock.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kTimeout = 5.0;

TEST(DriverLock, BelongsToTheFirstClientThatDrives) {
  DriverLock driver_lock{kTimeout};
  EXPECT_TRUE(driver_lock.may_write(1, 0.0));
  EXPECT_TRUE(driver_lock.drive(1, 0.0));
  EXPECT_FALSE(driver_lock.drive(2, 0.1));
  EXPECT_FALSE(driver_lock.may_write(2, 0.1));
  EXPECT_EQ(driver_lock.driver(0.1), ClientId{1});
}

TEST(DriverLock, IsFreeWhenTheDriverLeavesOrFallsSilent) {
  DriverLock driver_lock{kTimeout};
  EXPECT_TRUE(driver_lock.drive(1, 0.0));
  driver_lock.leave(2);
  EXPECT_FALSE(driver_lock.drive(2, 1.0));
  driver_lock.leave(1);
  EXPECT_TRUE(driver_lock.drive(2, 1.0));
  EXPECT_FALSE(driver_lock.drive(1, 1.0 + kTimeout - 0.1));
  EXPECT_TRUE(driver_lock.drive(1, 1.0 + kTimeout + 0.1));
}

TEST(DriverLock, IsTakenFromAnother) {
  DriverLock driver_lock{kTimeout};
  EXPECT_TRUE(driver_lock.drive(1, 0.0));
  driver_lock.take(2, 1.0);
  EXPECT_FALSE(driver_lock.drive(1, 1.1));
  EXPECT_TRUE(driver_lock.drive(2, 1.1));
}

TEST(DriverLock, IsNotRegainedByHoldingOn) {
  DriverLock driver_lock{kTimeout};
  EXPECT_TRUE(driver_lock.drive(1, 0.0));
  driver_lock.take(2, 1.0);
  double t = 1.0;
  for (; t < 3.0 * kTimeout; t += 0.04)
    EXPECT_FALSE(driver_lock.drive(1, t));  // 2 has left long ago
  EXPECT_TRUE(driver_lock.drive(1, t + kTimeout + 0.1)) << "released for a while";
  driver_lock.take(2, 100.0);
  driver_lock.take(1, 101.0);
  EXPECT_TRUE(driver_lock.drive(1, 101.1)) << "taken back";
}

}  // namespace
}  // namespace tandem
