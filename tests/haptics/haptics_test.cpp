// SPDX-License-Identifier: Apache-2.0
#include "tandem/haptics/haptics.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tandem {
namespace {

constexpr double kFar = 10.0;  // [m]
constexpr double kDt = 0.1;    // [s]
const HapticsParams kParams{.near = 0.4, .disagreement = 0.5, .deadband = 0.2};

// The steady-state feedback.
double felt(const std::optional<Twist2>& user, const Twist2& robot, double clearance) {
  Haptics haptics{kParams};
  (void)haptics.feel(user, robot, clearance, kDt);
  return haptics.feel(user, robot, clearance, kDt);
}

TEST(Haptics, AreZeroWhenAllAgreeAndNothingIsNear) {
  EXPECT_EQ(felt(Twist2{0.5, 0.2}, {0.5, 0.2}, kFar), 0.0);
  EXPECT_EQ(felt(Twist2{0.5, 0.2}, {0.45, 0.2}, kFar), 0.0);  // the deadband
}

TEST(Haptics, GrowWithDisagreementUpToItsFullMeasure) {
  EXPECT_NEAR(felt(Twist2{0.5, 0.0}, {0.2, 0.0}, kFar), 0.5, 1e-12);
  EXPECT_EQ(felt(Twist2{0.5, 0.0}, {0.0, 0.0}, kFar), 1.0);
  EXPECT_EQ(felt(Twist2{0.5, 0.0}, {0.0, 1.0}, kFar), 1.0);
}

TEST(Haptics, ARobotThatSpeedsUpAsFastAsItCanDoesNotDisagree) {
  Haptics haptics{kParams};
  constexpr double kAccel = 0.8;  // [m/s²]
  for (double v = 0.0; v < 0.8; v += kAccel * kDt)
    EXPECT_EQ(haptics.feel(Twist2{0.8, 0.0}, {v, 0.0}, kFar, kDt), 0.0) << v;
  (void)haptics.feel(Twist2{0.8, 0.0}, {0.4, 0.0}, kFar, kDt);  // and then it is held back
  EXPECT_GT(haptics.feel(Twist2{0.8, 0.0}, {0.4, 0.0}, kFar, kDt), 0.5);
}

TEST(Haptics, GrowWithNearness) {
  EXPECT_NEAR(felt(Twist2{0.5, 0.0}, {0.5, 0.0}, 0.1), 0.75, 1e-12);
  EXPECT_EQ(felt(Twist2{0.5, 0.0}, {0.5, 0.0}, -0.1), 1.0);
}

TEST(Haptics, AreNotFeltAfterReleasingTheStick) {
  EXPECT_EQ(felt(std::nullopt, {0.5, 0.0}, 0.0), 0.0);
  EXPECT_EQ(felt(Twist2{}, {0.5, 0.0}, 0.0), 0.0);
}

TEST(Haptics, AreZeroForNonFiniteInputs) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(felt(Twist2{kNaN, 0.0}, {}, kInf), 0.0);
  EXPECT_EQ(felt(Twist2{0.5, 0.0}, {0.5, 0.0}, kNaN), 0.0);
}

}  // namespace
}  // namespace tandem
