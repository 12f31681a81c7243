// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/driver_lock.hpp"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kTimeout = 5.0;

TEST(Seat, BelongsToTheFirstWhoDrives) {
  Seat seat{kTimeout};
  EXPECT_TRUE(seat.may_write(1, 0.0));
  EXPECT_TRUE(seat.drive(1, 0.0));
  EXPECT_FALSE(seat.drive(2, 0.1));
  EXPECT_FALSE(seat.may_write(2, 0.1));
  EXPECT_EQ(seat.driver(0.1), ClientId{1});
}

TEST(Seat, IsFreeWhenTheDriverLeavesOrFallsSilent) {
  Seat seat{kTimeout};
  EXPECT_TRUE(seat.drive(1, 0.0));
  seat.leave(2);
  EXPECT_FALSE(seat.drive(2, 1.0));
  seat.leave(1);
  EXPECT_TRUE(seat.drive(2, 1.0));
  EXPECT_FALSE(seat.drive(1, 1.0 + kTimeout - 0.1));
  EXPECT_TRUE(seat.drive(1, 1.0 + kTimeout + 0.1));
}

TEST(Seat, IsTakenFromAnother) {
  Seat seat{kTimeout};
  EXPECT_TRUE(seat.drive(1, 0.0));
  seat.take(2, 1.0);
  EXPECT_FALSE(seat.drive(1, 1.1));
  EXPECT_TRUE(seat.drive(2, 1.1));
}

TEST(Seat, IsNotRegainedByHoldingOn) {
  Seat seat{kTimeout};
  EXPECT_TRUE(seat.drive(1, 0.0));
  seat.take(2, 1.0);
  double t = 1.0;
  for (; t < 3.0 * kTimeout; t += 0.04) EXPECT_FALSE(seat.drive(1, t));  // 2 has left long ago
  EXPECT_TRUE(seat.drive(1, t + kTimeout + 0.1)) << "let go for a while";
  seat.take(2, 100.0);
  seat.take(1, 101.0);
  EXPECT_TRUE(seat.drive(1, 101.1)) << "taken back";
}

}  // namespace
}  // namespace tandem
