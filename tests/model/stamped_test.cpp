// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tandem/model/stamped.hpp"

namespace tandem {
namespace {

TEST(Stamped, IsNeverFreshBeforeItHasAValue) {
  const Stamped<int> none;
  EXPECT_TRUE(std::isinf(none.age(0.0)));
  EXPECT_FALSE(none.fresh(0.0, 1e12));
}

TEST(Stamped, IsFreshUntilItsTimeOut) {
  const Stamped<int> seven{7, 10.0};
  EXPECT_EQ(seven.age(10.5), 0.5);
  EXPECT_TRUE(seven.fresh(10.0, 0.0));
  EXPECT_TRUE(seven.fresh(10.5, 0.5));
  EXPECT_FALSE(seven.fresh(10.5, 0.49));
}

TEST(Stamped, IsNotFreshIfItIsOfTheFuture) {
  const Stamped<int> seven{7, 10.0};
  EXPECT_FALSE(seven.fresh(9.9, 0.5));
}

TEST(Stamped, HasNoValueAfterAReset) {
  Stamped<int> seven{7, 10.0};
  seven.reset();
  EXPECT_EQ(seven.value, 0);
  EXPECT_FALSE(seven.fresh(10.0, 1e12));
}

}  // namespace
}  // namespace tandem
